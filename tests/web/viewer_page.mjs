// SPDX-License-Identifier: Apache-2.0
// The viewer in a window of its own, as tests see it: what it recorded, what is on the screen. Every wait has a
// deadline, and when one has passed the error says what the page showed.
import { ending, step, until } from './steps.mjs';
import { stopBrowser } from './harness.mjs';

/** In the page: what it shows, in words. */
function describe() {
  const { events = [], geometry } = window.nmcViewer ?? {};
  const runs = [];
  for (const { type } of events) {
    if (runs.at(-1)?.type === type) ++runs.at(-1).count;
    else runs.push({ type, count: 1 });
  }
  const shown = (id) => document.getElementById(id)?.hidden === false;
  const textOf = (id) => (shown(id) ? document.getElementById(id).textContent.trim().replace(/\s+/g, ' ') : '');
  return `events: ${runs.map(({ type, count }) => (count > 1 ? `${count} x ${type}` : type)).join(', ') || 'none'}` +
    `; triangles: ${(geometry?.index?.count ?? 0) / 3}; status: "${textOf('status')}"; message: "${textOf('message')}"`;
}

export class ViewerPage {
  /** What the page complained of: errors on the console, uncaught ones, those of WebGL. */
  complaints = [];
  #seen = 'nothing yet';
  #hasCrashed = false;

  constructor(browser, context, page) {
    this.browser = browser;
    this.context = context;
    this.page = page;
    page.on('console', (message) => {
      if (message.type() === 'error' || /INVALID_|GL_/.test(message.text())) this.complaints.push(message.text());
    });
    page.on('pageerror', (error) => this.complaints.push(String(error)));
    page.on('crash', () => { this.#hasCrashed = true; });
  }

  /** Opens `url`; the window closes after the test `t`, whatever its end. A browser that does not close it is killed. */
  static async open(t, browser, url, { width = 660, height = 500, ...options } = {}) {
    const context = await step('a new window', 120, () => browser.newContext({ viewport: { width, height }, ...options }));
    const page = await step('a new page', 120, () => context.newPage());
    const viewer = new ViewerPage(browser, context, page);
    t.after(() => viewer.close());
    await viewer.step(`the page ${url}`, 120, () => page.goto(url, { timeout: 0 }));
    return viewer;
  }

  async close() {
    if (!this.browser.isConnected()) return;
    if (!await ending('the end of a window', 30, () => this.context.close())) await stopBrowser(this.browser);
  }

  /** step() of steps.mjs, with what the page shows in its error. */
  step(what, seconds, work) { return step(what, seconds, work, () => this.#sight()); }
  until(what, condition, seconds = 120) { return until(what, seconds, condition, () => this.#sight()); }

  async #sight() {
    await Promise.race([
      this.page.evaluate(describe).then((text) => { this.#seen = text; }, () => {}),
      new Promise((resolve) => { setTimeout(resolve, 1500); }),
    ]);
    const subject = this.#hasCrashed ? 'The page has crashed; before, it' : 'The page';
    return `${subject} showed ${this.#seen}; it complained of: ${this.complaints.join(' / ') || 'nothing'}`;
  }

  /** page.evaluate() with a deadline. */
  evaluate(work, argument, seconds = 120) {
    const text = String(work).replace(/\s+/g, ' ').slice(0, 100);
    return this.step(`in the page, ${text}`, seconds, () => this.page.evaluate(work, argument));
  }
  click(selector) { return this.step(`a click on ${selector}`, 120, () => this.page.click(selector, { timeout: 0 })); }
  press(key) { return this.step(`the key ${key}`, 60, () => this.page.keyboard.press(key)); }
  give(file) { return this.step(`the file ${file}`, 120, () => this.page.setInputFiles('#file', file, { timeout: 0 })); }
  text(selector) { return this.step(`the text of ${selector}`, 60, () => this.page.locator(selector).innerText({ timeout: 0 })); }
  screenshot(options = {}) { return this.step('a screenshot', 180, () => this.page.screenshot({ timeout: 0, ...options })); }

  /** What the page recorded of one kind, in order. */
  async events(type) {
    const look = `[(window.nmcViewer?.events ?? []).filter((event) => event.type === '${type}'), (${describe})()]`;
    const [events, sight] = await this.step(`the events "${type}"`, 120, () => this.page.evaluate(look));
    this.#seen = sight;
    return events;
  }
  first(type, seconds) { return this.until(`the first event "${type}"`, async () => (await this.events(type))[0], seconds); }

  /** Waits until the card has drawn one more frame. */
  drawn() {
    return this.step('one more frame', 180, () => this.page.evaluate(() => new Promise((resolve, reject) => {
      const { stage } = window.nmcViewer;
      const gl = stage.renderer.getContext();
      stage.invalidate();
      requestAnimationFrame(() => requestAnimationFrame(() => {
        const fence = gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0);
        gl.flush();
        const look = () => {
          if (gl.isContextLost()) reject(new Error('the WebGL context is lost'));
          else if (gl.getSyncParameter(fence, gl.SYNC_STATUS) === gl.SIGNALED) resolve();
          else setTimeout(look, 20);
        };
        look();
      }));
    })));
  }

  /** Whether the page around the middle of the bounds is another picture with the canvas than without. */
  async showsSurface() {
    const clip = await this.evaluate(() => {
      const { stage } = window.nmcViewer;
      const { clientWidth, clientHeight } = document.getElementById('canvas');
      const at = stage.controls.target.clone().project(stage.camera);
      const width = clientWidth / (stage.isSplit ? 2 : 1);
      return { x: (0.5 + 0.5 * at.x) * width - 50, y: (0.5 - 0.5 * at.y) * clientHeight - 50, width: 100, height: 100 };
    });
    const shown = await this.screenshot({ clip });
    await this.evaluate(() => { document.getElementById('canvas').style.visibility = 'hidden'; });
    const without = await this.screenshot({ clip });
    await this.evaluate(() => { document.getElementById('canvas').style.visibility = ''; });
    return !shown.equals(without);
  }
}
