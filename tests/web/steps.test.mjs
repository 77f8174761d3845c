// SPDX-License-Identifier: Apache-2.0
// What keeps the suites from hanging.
import assert from 'node:assert/strict';
import { spawnSync } from 'node:child_process';
import { readFileSync } from 'node:fs';
import { dirname } from 'node:path';
import { test } from 'node:test';
import { fileURLToPath } from 'node:url';

import { step, until } from './steps.mjs';

const never = () => new Promise(() => {});

/** A module of its own beside this file: what it printed and its exit code. It has 60 seconds. */
function runModule(source) {
  const { status, signal, stdout, stderr } = spawnSync(process.execPath, ['--input-type=module', '-e', source],
    { cwd: dirname(fileURLToPath(import.meta.url)), encoding: 'utf8', timeout: 60000, killSignal: 'SIGKILL' });
  assert.equal(signal, null, `it did not end: ${stdout}${stderr}`);
  return { status, stdout, stderr };
}
function isRunning(id) {
  try {
    return !/^\d+ \(.*\) [ZX]/.test(readFileSync(`/proc/${id}/stat`, 'utf8'));
  } catch {
    return false;
  }
}

test('a step that is late names itself, the step around it and what was seen', async () => {
  const outer = step('the whole', 5, () => step('a part', 0.05, never, async () => 'The page showed nothing.'));
  await assert.rejects(outer, { message: 'the whole: a part: not done after 0.05 s\nThe page showed nothing.' });
});

test('a step whose page does not answer any more is late all the same', async () => {
  await assert.rejects(step('a part', 0.05, never, never), { message: 'a part: not done after 0.05 s' });
});

test('an error keeps its first line and how the browser ended, an assertion all of it', async () => {
  const gone = async () => { throw new Error('Target closed\nBrowser logs:\n[pid=7] <process did exit: exitCode=null, signal=SIGKILL>'); };
  await assert.rejects(step('a click', 5, gone),
    { message: 'a click: Target closed <process did exit: exitCode=null, signal=SIGKILL>' });
  await assert.rejects(step('a click', 5, async () => assert.equal(1, 2)), { name: 'AssertionError', actual: 1, expected: 2 });
});

test('until asks again, and no more after its deadline', async () => {
  let count = 0;
  assert.equal(await until('three', 5, () => (++count === 3 ? 'yes' : null)), 'yes');
  await assert.rejects(until('four', 0.12, () => { ++count; }), /^Error: four: not done after 0.12 s/);
  const asked = count;
  await new Promise((resolve) => { setTimeout(resolve, 150); });
  assert.equal(count, asked);
});

test('a run that does not end says what it waits for and ends, with its children', () => {
  const { status, stdout, stderr } = runModule(`
    import { spawn } from 'node:child_process';
    import { endWithin, step } from './steps.mjs';
    const child = spawn('sleep', ['1000'], { detached: true });
    console.log(child.pid);
    endWithin(0.5, 'a suite');
    step('the end of all days', 600, () => new Promise(() => {}));`);
  assert.equal(status, 1);
  assert.match(stderr, /# a suite has not ended after 0.5 s and is stopped[^]*# {3}the end of all days: for \d+ of 600 s[^]*ProcessWrap/);
  assert.ok(!isRunning(Number(stdout)), 'the child lives on');
});

test('servers and a trace that a failed test leaves do not keep the process', async () => {
  const { status, stdout } = runModule(`
    import { startBreakingProxy, startNginx, temporaryFolder, traceMainThread } from './harness.mjs';
    const nginx = await startNginx(temporaryFolder());
    await startBreakingProxy(nginx.port, 100, '/');
    const session = { send: async () => ({ processInfo: [{ type: 'renderer', id: process.pid }] }), detach: async () => {} };
    await traceMainThread({ newBrowserCDPSession: async () => session, startTracing: async () => {} }, null);
    console.log(nginx.url);`);
  assert.equal(status, 0);
  await assert.rejects(fetch(stdout.trim()), /fetch failed/);
});
