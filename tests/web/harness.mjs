// SPDX-License-Identifier: Apache-2.0
// What the tests and benchmarks of the web share: nginx on a free port of the loopback, a proxy that breaks
// connections, Debian's chromium. Nothing that is left open keeps the process from ending.
import assert from 'node:assert/strict';
import { execFileSync, spawn } from 'node:child_process';
import { existsSync, mkdirSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { connect, createServer } from 'node:net';
import { tmpdir } from 'node:os';
import { dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';

import { chromium } from 'playwright-core';

import { announce, ending, killChildren, step, until } from './steps.mjs';

export const here = dirname(fileURLToPath(import.meta.url));
export const root = join(here, '../..');

/** The path of a program, from the environment or $PATH. */
export function program(variable, name) {
  const path = process.env[variable];
  if (path) {
    assert.ok(existsSync(path), `${variable}: ${path} does not exist`);
    return path;
  }
  for (const folder of [...(process.env.PATH ?? '').split(':'), '/usr/sbin', '/sbin']) {
    if (folder && existsSync(join(folder, name))) return join(folder, name);
  }
  throw new Error(`${name} is missing: install it or set ${variable}`);
}

/** What a program prints; it has ten minutes, or options.timeout milliseconds (0: all it wants). */
export const run = (path, args, options = {}) =>
  execFileSync(path, args, { encoding: 'utf8', stdio: ['ignore', 'pipe', 'pipe'], timeout: 600000, ...options });

/** A folder that goes when the process ends. */
export function temporaryFolder() {
  const path = mkdtempSync(join(tmpdir(), 'nmc-web-'));
  process.on('exit', () => rmSync(path, { recursive: true, force: true, maxRetries: 3 }));
  return path;
}

async function freePort() {
  const server = createServer();
  await new Promise((resolve) => { server.listen(0, '127.0.0.1', resolve); });
  const { port } = server.address();
  await new Promise((resolve) => { server.close(resolve); });
  return port;
}

/** nginx with the viewer's own configuration: `folder` is its root, and /slow/ the same at 1 Mbit/s. */
export async function startNginx(folder) {
  const work = temporaryFolder();
  mkdirSync(join(work, 'logs'));
  const port = await freePort();
  const paths = ['client_body', 'proxy', 'fastcgi', 'uwsgi', 'scgi'].map((kind) => `${kind}_temp_path ${work}/${kind};`);
  const user = process.getuid?.() === 0 ? 'user root;' : '';
  writeFileSync(join(work, 'nginx.conf'), `${user}
    daemon off; worker_processes 1; pid ${work}/nginx.pid; error_log ${work}/logs/error.log;
    events { worker_connections 256; }
    http {
      access_log ${work}/logs/access.log;
      ${paths.join('\n      ')}
      server {
        listen 127.0.0.1:${port};
        root ${folder};
        include ${root}/viewer/serve/nmc-viewer.conf;
        location /slow/ { alias ${folder}/; limit_rate 125000; sendfile_max_chunk 16k; }
      }
    }`);
  // In a process group of its own, which ends as one.
  const server = spawn(program('NGINX', 'nginx'), ['-p', work, '-c', join(work, 'nginx.conf')],
    { stdio: ['ignore', 'ignore', 'pipe'], detached: true });
  let complaint = '';
  server.stderr.on('data', (data) => { complaint += data; });
  const hasEnded = () => server.exitCode !== null || server.signalCode !== null;
  const ended = new Promise((resolve) => { server.once('exit', resolve); });
  server.unref();
  server.stderr.unref();
  const url = `http://127.0.0.1:${port}`;
  await until('the start of nginx', 60, async () => {
    if (hasEnded()) throw new Error(`it has ended: ${complaint}`);
    return fetch(url, { signal: AbortSignal.timeout(5000) }).then(() => true, () => false);
  });
  return {
    url, port,
    log: () => readFileSync(join(work, 'logs/access.log'), 'utf8'),
    stop: async () => {
      if (hasEnded()) announce(`nginx had ended by itself: ${complaint}`);
      else server.kill('SIGTERM');
      await ending('the end of nginx', 20, () => ended);
      try {
        process.kill(-server.pid, 'SIGKILL');  // workers that have lost their master, or do not end
      } catch {
        return;  // there are none
      }
    },
  };
}

/** A proxy before `port`: the first answer to a request for `path` breaks off after `cut` bytes; all others pass. */
export async function startBreakingProxy(port, cut, path) {
  let hasBroken = false;
  const sockets = new Set();
  const server = createServer((client) => {
    const upstream = connect(port, '127.0.0.1');
    let passed = -Infinity;
    client.on('data', (data) => {
      passed = data.toString('latin1').startsWith(`GET ${path} `) ? 0 : -Infinity;
      upstream.write(data);
    });
    upstream.on('data', (data) => {
      passed += data.length;
      if (hasBroken || passed <= cut) {
        client.write(data);
        return;
      }
      hasBroken = true;
      upstream.destroy();
      client.write(data.subarray(0, Math.max(0, data.length - (passed - cut))), () => {
        setTimeout(() => client.resetAndDestroy(), 50);
      });
    });
    upstream.on('close', () => client.end());
    client.on('close', () => upstream.destroy());
    for (const socket of [client, upstream]) {
      sockets.add(socket);
      socket.on('error', () => {});
      socket.on('close', () => sockets.delete(socket));
    }
  });
  server.unref();
  await new Promise((resolve) => { server.listen(0, '127.0.0.1', resolve); });
  return {
    url: `http://127.0.0.1:${server.address().port}`,
    hasBroken: () => hasBroken,
    stop: () => ending('the end of the proxy', 20, () => new Promise((resolve) => {
      server.close(resolve);
      for (const socket of sockets) socket.destroy();
    })),
  };
}

const marks = new WeakMap();
let browsers = 0;

/**
 * Chromium without a screen; WebGL in software, so that it needs no graphics card. One that does not come to life is
 * said and started once more: no page of ours has been in it yet.
 */
export async function startBrowser(moreArguments = []) {
  const start = async () => {
    const mark = `--nmc-browser=${process.pid}.${++browsers}`;
    try {
      return await step('the start of chromium', 120, async () => {
        const browser = await chromium.launch({
          executablePath: program('CHROMIUM', 'chromium'), timeout: 60000,
          args: ['--no-sandbox', '--use-gl=angle', '--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--ignore-gpu-blocklist',
            '--disable-dev-shm-usage', mark, ...moreArguments],
        });
        marks.set(browser, mark);
        const page = await browser.newPage();
        assert.equal(await page.evaluate(() => 6 * 7), 42);
        await page.close();
        return browser;
      });
    } catch (error) {
      killChildren(mark);
      throw error;
    }
  };
  return start().catch((error) => {
    announce(`CHROMIUM DID NOT START, once more: ${error.message}`);
    return start();
  });
}

/** Closes the browser, or kills it with all its processes when it does not answer. */
export async function stopBrowser(browser) {
  if (await ending('the end of chromium', 20, () => browser.close())) return;
  killChildren(marks.get(browser));
  await ending('the end of a killed chromium', 20, () => until('its last word', 15, () => !browser.isConnected()));
}

/** Ids of the browser's page processes. */
async function rendererIds(browser) {
  return step('the list of page processes', 60, async () => {
    const session = await browser.newBrowserCDPSession();
    const { processInfo } = await session.send('SystemInfo.getProcessInfo');
    await session.detach();
    return processInfo.filter(({ type }) => type === 'renderer').map(({ id }) => id);
  });
}

/**
 * Traces the tasks of a page's main thread, in a browser that has no other page at work. `stop()` gives their number and of the longest, in milliseconds: `wall`, as
 * a clock sees it; `processor`, its own work; and `held`, from its begin to its end without the time in which it was
 * ready to run and other programs had the processors (the kernel's run delay, proc(5): schedstat). `held` is what the
 * page itself is to blame for, waiting for a graphics card included, and `wall` on a machine that has nothing else to
 * do. The run delay is read every few milliseconds, so a reading may count some of the delay beside the task: on a busy
 * machine a task that is a little too long may pass, and none fails that should not.
 */
export async function traceMainThread(browser, page) {
  const delays = new Map((await rendererIds(browser)).map((id) => [id, []]));
  const now = () => Number(process.hrtime.bigint() / 1000n);  // the trace's clock, in microseconds
  const read = () => {
    for (const [id, rows] of delays) {
      try {
        rows.push([now(), Number(readFileSync(`/proc/${id}/task/${id}/schedstat`, 'utf8').split(' ')[1]) / 1e3]);
      } catch {
        delays.delete(id);  // it has ended
      }
    }
  };
  read();
  await step('the begin of a trace', 60, () => browser.startTracing(page, { categories: ['toplevel', 'cc', 'gpu', 'devtools.timeline'] }));
  const sampler = setInterval(read, 5);
  sampler.unref();
  const delayWithin = (rows, begin, end) => {
    const before = rows.findLast(([time]) => time <= begin);
    const after = rows.find(([time]) => time >= end);
    assert.ok(before && after, 'the trace and the kernel use different clocks');
    return after[1] - before[1];
  };
  return {
    cancel: () => clearInterval(sampler),
    stop: async () => {
      const trace = await step('the end of a trace', 120, () => browser.stopTracing()).finally(() => clearInterval(sampler));
      read();
      const { traceEvents } = JSON.parse(trace.toString('utf8'));
      const mains = new Set(traceEvents.filter(({ name, args }) => name === 'thread_name' && args.name === 'CrRendererMain')
        .map(({ pid, tid }) => `${pid}/${tid}`));
      const events = traceEvents.filter(({ ph, pid, tid }) => ph === 'X' && delays.has(pid) && mains.has(`${pid}/${tid}`));
      // A window closed before this one may have had the same process, which takes its compositor down now. The page that is
      // looked at keeps its own until after the trace.
      const closings = events.filter(({ name }) => name === 'LayerTreeHost::~LayerTreeHost');
      const tasks = events.filter(({ name, pid, ts, dur }) => /RunTask$/.test(name) &&
        !closings.some((closing) => closing.pid === pid && closing.ts >= ts && closing.ts + closing.dur <= ts + dur));
      const longest = { wall: 0, processor: 0, held: 0 };
      let slowest = null;
      for (const task of tasks) {
        const { ts, dur, tdur = 0, pid } = task;
        longest.wall = Math.max(longest.wall, dur / 1e3);
        longest.processor = Math.max(longest.processor, tdur / 1e3);
        if (dur / 1e3 <= longest.held) continue;
        const delay = delayWithin(delays.get(pid), ts, ts + dur);
        const held = Math.max(dur - delay, tdur) / 1e3;
        if (held <= longest.held) continue;
        longest.held = held;
        slowest = task;
      }
      return { count: tasks.length, longest, cause: slowest ? causeOf(slowest, events) : '' };
    },
  };
}

/** What takes most of a task, from the outside to the inside. */
function causeOf(task, events) {
  const inside = events.filter(({ ts, dur }) => ts >= task.ts && ts + dur <= task.ts + task.dur && 2 * dur > task.dur)
    .sort((a, b) => b.dur - a.dur);
  const names = inside.map(({ name, dur, args }) =>
    `${args?.src_func ?? args?.data?.functionName ?? name} ${(dur / 1e3).toFixed(0)} ms`);
  return [...new Set(names)].join(' > ');
}

/** Bytes that the browser's page processes hold, by the kernel's account. */
export async function rendererMemory(browser) {
  let bytes = 0;
  for (const id of await rendererIds(browser)) {
    try {
      bytes += 1024 * Number(/VmRSS:\s+(\d+)/.exec(readFileSync(`/proc/${id}/status`, 'utf8'))?.[1] ?? 0);
    } catch {
      continue;  // it has ended meanwhile
    }
  }
  return bytes;
}

/** viewer/dist in `folder`, built there. */
export function buildViewer(folder) {
  run(process.execPath, [join(root, 'viewer/node_modules/vite/bin/vite.js'), 'build', '--outDir', folder, '--emptyOutDir'],
    { cwd: join(root, 'viewer') });
}

/** Draco inside a GLB, as exporters write it: positions of `bits` bits, no other attributes. */
export async function writeDracoGlb(input, output, bits = 14) {
  const { NodeIO } = await import('@gltf-transform/core');
  const { KHRDracoMeshCompression } = await import('@gltf-transform/extensions');
  const draco3d = (await import('draco3d')).default;
  const io = new NodeIO().registerExtensions([KHRDracoMeshCompression]).registerDependencies({
    'draco3d.decoder': await draco3d.createDecoderModule(), 'draco3d.encoder': await draco3d.createEncoderModule(),
  });
  const document = await io.read(input);
  for (const mesh of document.getRoot().listMeshes()) {
    for (const primitive of mesh.listPrimitives()) primitive.setAttribute('NORMAL', null);
  }
  document.createExtension(KHRDracoMeshCompression).setRequired(true)
    .setEncoderOptions({ method: KHRDracoMeshCompression.EncoderMethod.EDGEBREAKER, quantizationBits: { POSITION: bits } });
  await io.write(output, document);
}

/** meshopt inside a GLB, by gltfpack: positions of `bits` bits. `simplify`: the share of triangles that is kept. */
export function writeMeshoptGlb(input, output, { bits = 14, simplify = 1 } = {}) {
  const share = simplify < 1 ? ['-si', String(simplify), '-se', '1'] : [];
  run(process.execPath, [join(here, 'node_modules/gltfpack/cli.js'), '-i', input, '-o', output, '-cc', '-vp', String(bits), ...share]);
}
