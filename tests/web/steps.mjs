// SPDX-License-Identifier: Apache-2.0
// Nothing here waits for ever: each wait has a name and a deadline, and a run that does not end is ended.
// NODE_DEBUG=steps prints how long each took.
import { readdirSync, readFileSync, writeSync } from 'node:fs';
import { debuglog } from 'node:util';

const log = debuglog('steps');
const underWay = new Set();

/** To the terminal at once, also when the process is about to end. */
export function announce(text) {
  writeSync(2, `${text.replace(/^/gm, '# ')}\n`);
}

export const sleep = (milliseconds) => new Promise((resolve) => { setTimeout(resolve, milliseconds); });

/** The first line of an error and how a browser ended: Playwright adds the browser's whole log. */
function shortly({ message }) {
  const ending = /<process did exit: [^>]*>/.exec(message)?.[0] ?? '';
  return `${message.split('\n')[0]} ${ending}`.trimEnd();
}

/**
 * What `work()` resolves to, if it does within so many seconds. An error names the step, the steps around it and, if
 * given, what `seen()` resolves to: what the page shows. Failed assertions go through as they are.
 */
export async function step(what, seconds, work, seen = () => '') {
  const entry = { what, since: Date.now(), seconds };
  const { stack } = new Error();
  underWay.add(entry);
  let timer;
  const late = new Promise((_, reject) => {
    timer = setTimeout(() => reject(new Error(`not done after ${seconds} s`)), 1e3 * seconds);
  });
  try {
    return await Promise.race([work(), late]);
  } catch (error) {
    if (error.code === 'ERR_ASSERTION') throw error;
    const inside = error.isOfStep ? error.message : `${shortly(error)}\n${await Promise.race([seen(), sleep(2000)]) ?? ''}`.trimEnd();
    const failure = Object.assign(new Error(`${what}: ${inside}`), { isOfStep: true });
    failure.stack = [`Error: ${failure.message}`, ...stack.split('\n').slice(2)].join('\n');
    throw failure;
  } finally {
    clearTimeout(timer);
    underWay.delete(entry);
    log('%d ms: %s', Date.now() - entry.since, what);
  }
}

/** The first true value of `condition()`, asked for twenty times a second. */
export function until(what, seconds, condition, seen) {
  let isOver = false;
  return step(what, seconds, async () => {
    for (let value; !isOver; await sleep(50)) if ((value = await condition())) return value;
    return null;
  }, seen).finally(() => { isOver = true; });
}

/** An end that is late or fails is said and no error: what it was for has been judged before. Whether it came. */
export function ending(what, seconds, work) {
  return step(what, seconds, work).then(() => true, (error) => {
    announce(`At the end: ${error.message}`);
    return false;
  });
}

/** Ends the children of this process with `mark` in their command line, each with its group where it leads one. */
export function killChildren(mark = '') {
  for (const name of readdirSync('/proc').filter((each) => /^\d+$/.test(each))) {
    try {
      const stat = readFileSync(`/proc/${name}/stat`, 'utf8');
      const [, parent, group] = stat.slice(stat.lastIndexOf(')') + 2).split(' ');
      if (Number(parent) !== process.pid || !readFileSync(`/proc/${name}/cmdline`, 'utf8').includes(mark)) continue;
      process.kill(group === name ? -Number(name) : Number(name), 'SIGKILL');
    } catch {
      continue;  // it has ended meanwhile
    }
  }
}
process.on('exit', () => killChildren());

let watchdog;
/** Ends this process with code 1 if it is still there after so many seconds, having said what it was doing. */
export function endWithin(seconds, whole = 'the suite') {
  clearTimeout(watchdog);
  watchdog = setTimeout(() => {
    announce(`${whole} has not ended after ${seconds} s and is stopped. Steps under way:`);
    for (const entry of underWay) {
      announce(`  ${entry.what}: for ${((Date.now() - entry.since) / 1e3).toFixed(0)} of ${entry.seconds} s`);
    }
    announce(`  open: ${process.getActiveResourcesInfo().join(', ')}`);
    process.exit(1);
  }, 1e3 * seconds);
  watchdog.unref();
}
