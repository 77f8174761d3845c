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
export async function until(condition, what, milliseconds = 60000) {
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
export function startBrowser() {
  return chromium.launch({
    executablePath: program('CHROMIUM', 'chromium'),
    args: ['--no-sandbox', '--use-gl=angle', '--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--ignore-gpu-blocklist',
      '--disable-dev-shm-usage'],
  });
}

/**
 * Traces the tasks of a page's main thread. `stop()` gives their number and the longest in milliseconds of processor
 * time: unlike time on the wall it does not count what other programs took meanwhile.
 */
export async function traceMainThread(browser, page) {
  await browser.startTracing(page, { categories: ['toplevel', 'disabled-by-default-devtools.timeline'] });
  return {
    stop: async () => {
      const { traceEvents } = JSON.parse((await browser.stopTracing()).toString('utf8'));
      const mains = new Set(traceEvents.filter(({ name, args }) => name === 'thread_name' && args.name === 'CrRendererMain')
        .map(({ pid, tid }) => `${pid}/${tid}`));
      const tasks = traceEvents.filter(({ name, ph, pid, tid }) =>
        ph === 'X' && /RunTask$/.test(name) && mains.has(`${pid}/${tid}`));
      return { count: tasks.length, longest: Math.max(0, ...tasks.map(({ tdur }) => (tdur ?? 0) / 1000)) };
    },
  };
}

/** Bytes that the browser's page processes hold, by the kernel's account. */
export function rendererMemory() {
  let bytes = 0;
  for (const id of readdirSync('/proc').filter((name) => /^\d+$/.test(name))) {
    try {
      const command = readFileSync(`/proc/${id}/cmdline`, 'utf8');
      if (!command.includes('--type=renderer') || !descendsFromHere(Number(id))) continue;
      bytes += 1024 * Number(/VmRSS:\s+(\d+)/.exec(readFileSync(`/proc/${id}/status`, 'utf8'))?.[1] ?? 0);
    } catch {
      continue;  // it has ended meanwhile
    }
  }
  return bytes;
}
function descendsFromHere(id) {
  for (let at = id; at > 1;) {
    if (at === process.pid) return true;
    at = Number(/PPid:\s+(\d+)/.exec(readFileSync(`/proc/${at}/status`, 'utf8'))?.[1] ?? 0);
  }
  return false;
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
  const share = simplify < 1 ? ['-si', String(simplify)] : [];
  run(process.execPath, [join(here, 'node_modules/gltfpack/cli.js'), '-i', input, '-o', output, '-c', '-vp', String(bits), ...share]);
}
