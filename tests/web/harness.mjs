// SPDX-License-Identifier: Apache-2.0
// What the tests and benchmarks of the web share: nginx on a free port of the loopback, a proxy that breaks
// connections, Debian's chromium.
import assert from 'node:assert/strict';
import { execFileSync, spawn } from 'node:child_process';
import { existsSync, mkdirSync, mkdtempSync, readdirSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { connect, createServer } from 'node:net';
import { tmpdir } from 'node:os';
import { dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';

import { chromium } from 'playwright-core';

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

export const run = (path, args, options = {}) =>
  execFileSync(path, args, { encoding: 'utf8', stdio: ['ignore', 'pipe', 'pipe'], ...options });

export const temporaryFolder = () => mkdtempSync(join(tmpdir(), 'nmc-web-'));
export const sleep = (milliseconds) => new Promise((resolve) => { setTimeout(resolve, milliseconds); });
export async function until(condition, what, milliseconds = 120000) {
  const end = Date.now() + milliseconds;
  for (let value; Date.now() < end; await sleep(50)) if ((value = await condition())) return value;
  throw new Error(`waited ${milliseconds} ms in vain for ${what}`);
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
  const server = spawn(program('NGINX', 'nginx'), ['-p', work, '-c', join(work, 'nginx.conf')], { stdio: ['ignore', 'ignore', 'pipe'] });
  let complaint = '';
  server.stderr.on('data', (data) => { complaint += data; });
  const url = `http://127.0.0.1:${port}`;
  await until(async () => {
    if (server.exitCode !== null) throw new Error(`nginx: ${complaint}`);
    return fetch(url).then(() => true, () => false);
  }, 'nginx', 10000);
  return {
    url, port,
    log: () => readFileSync(join(work, 'logs/access.log'), 'utf8'),
    stop: async () => {
      const gone = new Promise((resolve) => { server.once('exit', resolve); });
      server.kill('SIGTERM');
      await gone;
      rmSync(work, { recursive: true, force: true });
    },
  };
}

/** A proxy before `port`: the first answer to a request for `path` breaks off after `cut` bytes; all others pass. */
export async function startBreakingProxy(port, cut, path) {
  let hasBroken = false;
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
    for (const socket of [client, upstream]) socket.on('error', () => {});
  });
  await new Promise((resolve) => { server.listen(0, '127.0.0.1', resolve); });
  return {
    url: `http://127.0.0.1:${server.address().port}`,
    hasBroken: () => hasBroken,
    stop: () => new Promise((resolve) => {
      server.close(resolve);
      server.closeAllConnections?.();
    }),
  };
}

/** Chromium without a screen; WebGL in software, so that it needs no graphics card. */
export function startBrowser(moreArguments = []) {
  return chromium.launch({
    executablePath: program('CHROMIUM', 'chromium'),
    args: ['--no-sandbox', '--use-gl=angle', '--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--ignore-gpu-blocklist',
      '--disable-dev-shm-usage', ...moreArguments],
  });
}

/** Ids of the browser's page processes. */
function rendererIds() {
  return readdirSync('/proc').filter((name) => /^\d+$/.test(name)).map(Number).filter((id) => {
    try {
      return readFileSync(`/proc/${id}/cmdline`, 'utf8').includes('--type=renderer') && descendsFromHere(id);
    } catch {
      return false;  // it has ended meanwhile
    }
  });
}
function descendsFromHere(id) {
  for (let at = id; at > 1;) {
    if (at === process.pid) return true;
    at = Number(/PPid:\s+(\d+)/.exec(readFileSync(`/proc/${at}/status`, 'utf8'))?.[1] ?? 0);
  }
  return false;
}

/**
 * Traces the tasks of a page's main thread. `stop()` gives their number and of the longest, in milliseconds: `wall`, as
 * a clock sees it; `processor`, its own work; and `held`, from its begin to its end without the time in which it was
 * ready to run and other programs had the processors (the kernel's run delay, proc(5): schedstat). `held` is what the
 * page itself is to blame for, waiting for a graphics card included, and `wall` on a machine that has nothing else to
 * do. The run delay is read every few milliseconds, so a reading may count some of the delay beside the task: on a busy
 * machine a task that is a little too long may pass, and none fails that should not.
 */
export async function traceMainThread(browser, page) {
  const delays = new Map(rendererIds().map((id) => [id, []]));
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
  const sampler = setInterval(read, 5);
  await browser.startTracing(page, { categories: ['toplevel', 'cc', 'gpu', 'devtools.timeline'] });
  const delayWithin = (rows, begin, end) => {
    const before = rows.findLast(([time]) => time <= begin);
    const after = rows.find(([time]) => time >= end);
    assert.ok(before && after, 'the trace and the kernel use different clocks');
    return after[1] - before[1];
  };
  return {
    stop: async () => {
      const { traceEvents } = JSON.parse((await browser.stopTracing()).toString('utf8'));
      clearInterval(sampler);
      const mains = new Set(traceEvents.filter(({ name, args }) => name === 'thread_name' && args.name === 'CrRendererMain')
        .map(({ pid, tid }) => `${pid}/${tid}`));
      const events = traceEvents.filter(({ ph, pid, tid }) => ph === 'X' && mains.has(`${pid}/${tid}`));
      const tasks = events.filter(({ name }) => /RunTask$/.test(name));
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
export function rendererMemory() {
  let bytes = 0;
  for (const id of rendererIds()) {
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
