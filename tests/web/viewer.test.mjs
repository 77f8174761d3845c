// SPDX-License-Identifier: Apache-2.0
// The viewer in chromium before a real nginx. Programs by environment: NMC_DECODE, NMC_MAKE_ROCK. The pictures of
// docs/images: NMC_PICTURES is the folder they go to, NMC_PICTURE_STREAM a stream, NMC_PICTURE_ORIGINAL its scan,
// NMC_PICTURE_FROM the direction to look from.
import assert from 'node:assert/strict';
import { copyFileSync, mkdirSync, readFileSync, statSync, truncateSync, writeFileSync } from 'node:fs';
import { basename, join } from 'node:path';
import { after, before, test } from 'node:test';

import {
  buildViewer, program, rendererMemory, run, startBreakingProxy, startBrowser, startNginx, stopBrowser, temporaryFolder,
  traceMainThread, writeMeshoptGlb,
} from './harness.mjs';
import { readScan, writeDracoGlbOfSize, writePlainGlb, writePly } from './meshes.mjs';
import { endWithin, sleep, step } from './steps.mjs';
import { ViewerPage } from './viewer_page.mjs';

const folder = temporaryFolder();
const decode = program('NMC_DECODE', 'nmc-decode');
let nginx, browser;
endWithin(1080);  // CTest's 1200 s, less what run_tests.sh may need before

/** What nmc-decode says of a stream: the hash of its finest mesh. */
function hashOf(path) {
  const said = run(decode, [path, '--hash', '--no-output']);
  return /positions ([0-9a-f]{16})/.exec(said)[1];
}

before(async () => {
  buildViewer(folder);
  for (const [name, ...size] of [['rock.nmc'], ['middle.nmc', '7', '24'], ['small.nmc', '6', '12']]) {
    run(program('NMC_MAKE_ROCK', 'make-rock'), [join(folder, name), ...size]);
  }
  const small = readFileSync(join(folder, 'small.nmc'));
  const damaged = Buffer.from(small);
  damaged[Math.floor(0.8 * damaged.length)] ^= 0x55;
  writeFileSync(join(folder, 'damaged.nmc'), damaged);
  writeFileSync(join(folder, 'cut.nmc'), small);
  truncateSync(join(folder, 'cut.nmc'), Math.floor(0.8 * small.length));
  writeFileSync(join(folder, 'empty.nmc'), '');
  writeFileSync(join(folder, 'draco.nmc'), Buffer.concat([Buffer.from('DRACO\x02\x02\x01\x01\x00\x00'), Buffer.alloc(500, 7)]));
  nginx = await startNginx(folder);
});
after(async () => {
  endWithin(60, 'the end of the suite');
  if (browser) await stopBrowser(browser);
  await nginx?.stop();
});

/** The viewer in a window of its own, until the test `t` is over. A browser that a test has lost is not the next one's. */
async function open(t, path, { url = nginx.url, ...options } = {}) {
  if (!browser?.isConnected()) browser = await startBrowser();
  return ViewerPage.open(t, browser, `${url}/${path}`, options);
}

test('nginx sends the page under a strict policy', async () => {
  const page = await step('the page', 60, () => fetch(nginx.url));
  const policy = page.headers.get('content-security-policy');
  assert.match(policy, /default-src 'none'/);
  assert.match(policy, /script-src 'self' 'wasm-unsafe-eval';/);
  assert.doesNotMatch(policy, /'unsafe-eval'|'unsafe-inline'|blob:|data:/);
  const part = await step('a part of a stream', 60, () => fetch(`${nginx.url}/rock.nmc`, { headers: { range: 'bytes=100-' } }));
  assert.equal(part.status, 206);
});

/** Loads the rock over the slow line, looks at all there is to see, and gives the longest tasks of the page. */
async function loadRock(t, expected) {
  const viewer = await open(t, '');
  await viewer.first('ready');
  const trace = await traceMainThread(browser, viewer.page);
  t.after(() => trace.cancel());
  await viewer.evaluate(() => {
    document.getElementById('url').value = 'slow/rock.nmc';
    document.getElementById('address').requestSubmit();
  });
  const begin = await viewer.first('open');
  const firstLayer = await viewer.first('layer');
  assert.ok(firstLayer.bytes < 64000, `first mesh after ${firstLayer.bytes} bytes`);
  const complete = await viewer.first('complete', 600);
  assert.equal(complete.hash, expected);
  const layers = await viewer.events('layer');
  assert.ok(layers.length >= 7, `${layers.length} meshes`);
  assert.equal(layers.at(-1).triangles, 2097152);
  assert.ok(complete.time - begin.time > 15000, 'the line was not slow');
  await viewer.drawn();
  const { count, longest, cause } = await trace.stop();
  assert.equal(await viewer.evaluate(() => window.nmcViewer.stage.renderer.info.render.triangles), 2097152);
  assert.ok(await viewer.showsSurface(), 'the surface is not on the screen');
  t.diagnostic(`first mesh after ${firstLayer.bytes} bytes, ${layers.length - 1} refinements, complete after ` +
    `${((complete.time - begin.time) / 1000).toFixed(1)} s; ${count} tasks of the page, the longest in milliseconds: ` +
    Object.entries(longest).map(([name, value]) => `${name} ${value.toFixed(1)}`).join(', ') + `; held by ${cause}`);
  assert.deepEqual(viewer.complaints, []);
  assert.ok(count > 100, 'nothing was traced');
  await viewer.close();
  return { longest, cause };
}

test('a stream of 3 MB at 1 Mbit/s: early, often, without a long task, and exact', async (t) => {
  const size = statSync(join(folder, 'rock.nmc')).size;
  assert.ok(size > 2.9e6, `${size} bytes`);
  const expected = hashOf(join(folder, 'rock.nmc'));
  let { longest, cause } = await loadRock(t, expected);
  // What the page does itself it does every time; a browser whose own threads found no processor is another time luckier.
  if (longest.held > 50) ({ longest, cause } = await loadRock(t, expected));
  assert.ok(longest.held <= 50, `a task of ${longest.held} ms held the page, twice: ${cause}`);
});

test('a connection that breaks leaves the mesh standing and is taken up again', async (t) => {
  const size = statSync(join(folder, 'middle.nmc')).size;
  const proxy = await startBreakingProxy(nginx.port, Math.floor(size / 2), '/slow/middle.nmc');
  t.after(() => proxy.stop());
  const viewer = await open(t, '?src=slow/middle.nmc', { url: proxy.url });
  const retry = await viewer.first('retry');
  assert.ok(retry.loaded > 0 && retry.loaded < size, `${retry.loaded} of ${size} bytes`);
  assert.ok(await viewer.evaluate(() => window.nmcViewer.geometry.index.count) > 0);
  const complete = await viewer.first('complete');
  assert.equal(complete.hash, hashOf(join(folder, 'middle.nmc')));
  assert.equal((await viewer.events('retry')).length, 1);
  assert.match(nginx.log(), /"GET \/slow\/middle.nmc HTTP\/1.1" 206 /);
  assert.ok(viewer.complaints.every((text) => /Failed to load resource: net::ERR/.test(text)), viewer.complaints.join());
});

test('a pause ends the request, and going on asks for the rest', async (t) => {
  const path = '/slow/rock.nmc?pause';
  const answers = () => nginx.log().split('\n').filter((line) => line.includes(`"GET ${path} `))
    .map((line) => / HTTP\/1.1" (\d+) (\d+) /.exec(line).slice(1).map(Number));
  const viewer = await open(t, `?src=${encodeURIComponent(path.slice(1))}`);
  const received = () => viewer.evaluate(() => window.nmcViewer.geometry.receivedBytes);
  await viewer.first('layer');
  await viewer.click('#pause');
  const [[status, sent]] = await viewer.until('the end of the request', () => (answers().length > 0 ? answers() : null));
  assert.equal(status, 200);
  assert.ok(sent < statSync(join(folder, 'rock.nmc')).size, `all ${sent} bytes were sent`);
  const before = await received();
  await sleep(500);
  assert.equal(await received(), before);
  await viewer.click('#pause');
  await viewer.until('more bytes', async () => await received() > before + 20000);
  assert.deepEqual([await viewer.events('retry'), viewer.complaints], [[], []]);
  await viewer.close();
  await viewer.until('the end of the second request', () => answers().length > 1);
  assert.equal(answers()[1][0], 206);
  assert.equal(answers().length, 2);
});

const messages = [
  ['damaged.nmc', /damaged/, true], ['cut.nmc', /cut off/, true], ['empty.nmc', /empty/, false],
  ['draco.nmc', /Not an nmc file[^]*Draco/, false], ['nothing.nmc', /no such file/, false],
];
test('files that cannot be read: the right message, and what was decoded stays', async (t) => {
  const viewer = await open(t, '');
  await viewer.first('ready');
  for (const [index, [name, text, hasMesh]] of messages.entries()) {
    await t.test(name, async () => {
      await viewer.evaluate((url) => {
        document.getElementById('home').click();
        document.getElementById('url').value = url;
        document.getElementById('address').requestSubmit();
      }, name);
      await viewer.until('the message', async () => (await viewer.events('error')).length > index);
      assert.match(await viewer.text('#message'), text);
      const triangles = await viewer.evaluate(() => (window.nmcViewer.geometry?.index?.count ?? 0) / 3);
      assert.equal(triangles > 0, hasMesh, `${triangles} triangles`);
    });
  }
});

test('fifty loads leave no worker and no memory behind', async (t) => {
  const viewer = await open(t, '');
  await viewer.first('ready');
  const load = (count) => viewer.evaluate(async (times) => {
    const { loader } = window.nmcViewer;
    for (let i = 0; i < times; ++i) {
      const geometry = await loader.open('middle.nmc');
      await geometry.finished;
      geometry.dispose();
    }
  }, count, 300);
  const session = await viewer.step('a session', 60, () => viewer.context.newCDPSession(viewer.page));
  const heap = () => viewer.step('the size of the heap', 120, async () => {
    await session.send('HeapProfiler.collectGarbage');
    await sleep(300);
    await session.send('HeapProfiler.collectGarbage');
    const { usedSize, backingStorageSize = 0 } = await session.send('Runtime.getHeapUsage');
    return usedSize + backingStorageSize;
  });
  const memory = async () => [await heap(), await rendererMemory(browser)];
  await load(5);
  const before = await memory();
  await load(45);
  const later = await memory();
  assert.ok(viewer.page.workers().length >= 1);
  await viewer.evaluate(() => { window.nmcViewer.loader.dispose(); });
  await viewer.until('the end of the workers', () => viewer.page.workers().length === 0);
  await sleep(500);
  const end = await memory();
  const megabytes = (values) => values.map((bytes) => (bytes / 1e6).toFixed(1)).join(' / ');
  t.diagnostic(`page heap / process in MB: after 5 loads ${megabytes(before)}, after 50 ${megabytes(later)}, ` +
    `after dispose ${megabytes(end)}`);
  assert.ok(later[0] < before[0] + 3e6, 'the page keeps what was disposed of');
  assert.ok(later[1] < before[1] + 100e6, 'the process grows with every load');
  assert.ok(end[1] <= later[1], 'the workers kept their memory');
});

test('overlays, sliders, heat map and comparison; pictures', async (t) => {
  const pictures = process.env.NMC_PICTURES ?? join(folder, 'pictures');
  mkdirSync(pictures, { recursive: true });
  // Pictures of a scan need one that is encoded already; the rock stands in for it.
  const stream = process.env.NMC_PICTURE_STREAM ?? join(folder, 'middle.nmc');
  const name = basename(stream);
  if (process.env.NMC_PICTURE_STREAM) copyFileSync(stream, join(folder, name));
  const original = process.env.NMC_PICTURE_ORIGINAL;
  const at = (file) => join(folder, file);
  let triangles = 40000;
  if (original) {
    const scan = await readScan(original);
    triangles = scan.indices.length / 3;
    writePly(at('original.ply'), scan);
    writePlainGlb(at('plain.glb'), scan);
  } else {
    for (const file of ['original.ply', 'plain.glb']) run(decode, [stream, '-o', at(file), '-f', '--max-triangles', '40000']);
  }
  writeMeshoptGlb(at('plain.glb'), at('meshopt.glb'), { bits: 12 });
  await writeDracoGlbOfSize(at('plain.glb'), at('draco.glb'), triangles, statSync(stream).size);

  const view = process.env.NMC_PICTURE_FROM ?? '0.35,0.22,1';
  const viewer = await open(t,
    `?src=${name}&from=${view}${process.env.NMC_PICTURES ? '&smooth' : ''}`, { width: 960, height: 600, reducedMotion: 'reduce' });
  const take = async (picture) => {
    await sleep(500);  // a morph may be under way
    await viewer.drawn();
    assert.ok(await viewer.showsSurface(), `${picture}: the surface is not on the screen`);
    await viewer.screenshot({ path: join(pictures, `viewer-${picture}.png`) });
    const { size } = statSync(join(pictures, `viewer-${picture}.png`));
    assert.ok(size > 10000, `viewer-${picture}.png: ${size} bytes`);
    t.diagnostic(`viewer-${picture}.png: ${size} bytes`);
  };
  await viewer.first('complete');
  const header = await viewer.evaluate(() => window.nmcViewer.geometry.header);
  await take('final');
  // What the first bytes of the stream show: the same that was on the screen when they had come.
  const show = async (bytes) => {
    const count = (await viewer.events('pick')).length;
    await viewer.step(`${bytes} on the slider`, 120, async () => {
      await viewer.page.locator('#bytes').fill(String(Math.floor(bytes)), { timeout: 0 });
      await viewer.page.locator('#bytes').blur({ timeout: 0 });
    });
    await viewer.until(`the mesh of ${bytes} bytes`, async () => (await viewer.events('pick')).length > count);
  };
  await show(0);
  await take('first');
  // Lines here, where they are few: drawn by the processor, those of the whole stream take seconds.
  for (const overlay of ['#wire', '#base', '[data-overlay="levels"]']) await viewer.click(overlay);
  await viewer.drawn();
  assert.ok(await viewer.showsSurface(), 'lines and levels are not on the screen');
  for (const overlay of ['#wire', '#base', '[data-overlay="plain"]']) await viewer.click(overlay);
  await show(header.streamBytes / 2);
  await take('half');
  await show(header.streamBytes);

  await viewer.click('[data-overlay="offsets"]');
  await viewer.until('the legend of offsets', async () => (await viewer.events('legend')).some(({ text }) => /outward/.test(text)));
  await viewer.click('[data-overlay="off-normal"]');
  await viewer.until('the legend of vertices', async () => (await viewer.events('legend')).some(({ text }) => /sideways/.test(text)));
  await viewer.click('[data-overlay="plain"]');

  await show(header.streamBytes / 20);
  const picked = (await viewer.events('pick')).at(-1);
  assert.equal(await viewer.evaluate(() => window.nmcViewer.view.geometry.layer.index), picked.index);
  await show(header.streamBytes);
  assert.ok(await viewer.evaluate(() => window.nmcViewer.view.geometry === window.nmcViewer.geometry));

  await viewer.give(join(folder, 'original.ply'));
  await viewer.until('the heat map', async () => (await viewer.events('legend')).some(({ text }) => /RMS/.test(text)));
  await take('heatmap');

  await viewer.click('[data-overlay="plain"]');
  for (const [file, kind] of [['plain.glb', 'GLB'], ['meshopt.glb', 'meshopt GLB'], ['draco.glb', 'Draco GLB']]) {
    await viewer.give(join(folder, file));
    await viewer.until(file, async () => (await viewer.events('compared')).some((event) => event.kind === kind));
  }
  await take('comparison');
  assert.deepEqual(viewer.complaints, []);
});

test('a small screen: a dropped file, keys, fingers, the sliders, a slow line', async (t) => {
  const viewer = await open(t, '', { width: 360, height: 640, hasTouch: true, isMobile: true, reducedMotion: 'reduce' });
  await viewer.first('ready');
  await viewer.evaluate(async () => {
    const dropped = new DataTransfer();
    dropped.items.add(new File([await (await fetch('small.nmc')).blob()], 'dropped.nmc'));
    document.body.dispatchEvent(new DragEvent('drop', { dataTransfer: dropped, bubbles: true, cancelable: true }));
  });
  await viewer.first('complete');
  assert.equal(await viewer.text('#name'), 'dropped.nmc');
  const panel = await viewer.step('the place of the panel', 60, () => viewer.page.locator('#panel').boundingBox({ timeout: 0 }));
  assert.ok(panel.width <= 360 && panel.height < 320, JSON.stringify(panel));
  assert.ok(await viewer.evaluate(() => document.documentElement.scrollWidth <= innerWidth));

  await viewer.step('the focus', 60, () => viewer.page.focus('#canvas', { timeout: 0 }));
  await viewer.press('w');
  assert.equal(await viewer.evaluate(() => document.getElementById('wire').getAttribute('aria-pressed')), 'true');
  await viewer.press('w');
  await viewer.press('[');
  await viewer.first('pick');
  await viewer.evaluate(() => {
    document.getElementById('level').value = '2';
    document.getElementById('level').dispatchEvent(new Event('input'));
  });
  await viewer.until('a mesh of level 2', () => viewer.evaluate(() => window.nmcViewer.view.geometry.layer.level === 2));

  const session = await viewer.step('a session', 60, () => viewer.context.newCDPSession(viewer.page));
  const touch = (type, ...points) => viewer.step(`a ${type}`, 60, () => session.send('Input.dispatchTouchEvent',
    { type, touchPoints: points.map(([x, y], id) => ({ x, y, id })) }));
  const eye = () => viewer.evaluate(() => {
    const { camera, controls } = window.nmcViewer.stage;
    const offset = camera.position.clone().sub(controls.target);
    return { distance: offset.length(), direction: offset.normalize().toArray() };
  });
  const before = await eye();
  await touch('touchStart', [120, 200]);
  for (const x of [150, 200, 250]) await touch('touchMove', [x, 200]);
  await touch('touchEnd');
  const turned = await viewer.until('a turn by one finger', async () => {
    const now = await eye();
    return now.direction.some((x, k) => Math.abs(x - before.direction[k]) > 0.2) ? now : null;
  });
  assert.ok(Math.abs(turned.distance / before.distance - 1) < 1e-6, 'one finger turns and does not zoom');
  await touch('touchStart', [160, 200], [200, 200]);
  for (const x of [20, 40, 60]) await touch('touchMove', [160 - x, 200], [200 + x, 200]);
  await touch('touchEnd');
  await viewer.until('a zoom by two fingers', async () => (await eye()).distance < 0.6 * before.distance);

  const shown = (await viewer.events('complete')).length;
  await viewer.step('the choice of a slow line', 60, () => viewer.page.selectOption('#network', '64', { timeout: 0 }));
  await viewer.click('#again');
  await viewer.until('the end of the slow load', async () => (await viewer.events('complete')).length > shown);
  const seconds = ((await viewer.events('complete')).at(-1).time - (await viewer.events('open')).at(-1).time) / 1e3;
  const { size } = statSync(join(folder, 'small.nmc'));
  assert.ok(seconds > (0.9 * 8 * size) / 64e3, `${size} bytes in ${seconds} s`);
  assert.deepEqual(viewer.complaints, []);
});
