// SPDX-License-Identifier: Apache-2.0
// Stated error against bytes, both by their logarithm: one point per layer, those in place filled.

export class Chart {
  #canvas;
  #context;
  #rows = [];
  #state = {};

  constructor(canvas, onPick) {
    this.#canvas = canvas;
    canvas.addEventListener('pointerdown', (event) => {
      const row = this.#nearest(event.offsetX);
      if (row) onPick(row.index);
    });
    new ResizeObserver(() => this.#drawSoon()).observe(canvas);
    // The first text on a canvas loads fonts, which takes longer than a frame: better before there is anything to see.
    // In main memory: a card that is busy with a large mesh would make the page wait for each line of the chart.
    this.#context = canvas.getContext('2d', { willReadFrequently: true });
    this.#context.fillText('10 kB 0.1%', 0, 0);
  }
  #frameRequest = 0;
  #drawSoon() {
    this.#frameRequest ||= requestAnimationFrame(() => {
      this.#frameRequest = 0;
      this.draw();
    });
  }
  /** `layers` and `diagonal` of a header; `shown`: index in place; `received`: bytes. */
  set(state) {
    this.#state = { ...this.#state, ...state };
    this.#rows = (this.#state.layers ?? []).filter(({ rmsError }) => rmsError !== undefined);
    this.#drawSoon();
  }
  #frame() {
    const { clientWidth: width, clientHeight: height } = this.#canvas;
    const first = this.#rows[0];
    const last = this.#rows.at(-1);
    const from = Math.log(first.bytes * 0.8);
    const to = Math.log(last.bytes * 1.15);
    const errors = this.#rows.flatMap(({ rmsError, maxError }) => [rmsError, maxError]).filter((e) => e > 0);
    const high = Math.log(Math.max(...errors) * 1.4);
    const low = Math.log(Math.min(...errors) / 1.4);
    return {
      width, height,
      x: (bytes) => 34 + ((width - 42) * (Math.log(Math.max(bytes, 1)) - from)) / (to - from || 1),
      y: (error) => 6 + ((height - 24) * (high - Math.log(Math.max(error, Math.exp(low))))) / (high - low || 1),
      low, high, from, to,
    };
  }
  #nearest(x) {
    if (this.#rows.length === 0) return null;
    const frame = this.#frame();
    return this.#rows.reduce((a, b) => (Math.abs(frame.x(b.bytes) - x) < Math.abs(frame.x(a.bytes) - x) ? b : a));
  }
  draw() {
    const ratio = window.devicePixelRatio;
    const canvas = this.#canvas;
    const size = [Math.round(canvas.clientWidth * ratio), Math.round(canvas.clientHeight * ratio)];
    if (canvas.width !== size[0] || canvas.height !== size[1]) [canvas.width, canvas.height] = size;
    if (this.#rows.length === 0 || canvas.width === 0) return;
    const g = this.#context;
    g.setTransform(ratio, 0, 0, ratio, 0, 0);
    g.clearRect(0, 0, canvas.clientWidth, canvas.clientHeight);
    g.font = '10px system-ui, sans-serif';
    const { width, height, x, y, low, high, from, to } = this.#frame();
    const { diagonal, shown = -1, received = 0 } = this.#state;
    g.strokeStyle = '#2b323d';
    g.fillStyle = '#98a2b3';
    g.textAlign = 'right';
    const decades = (high - low) / Math.LN10;
    const step = decades > 6 ? 2 : 1;
    for (let d = -12; d <= 1; d += step) {
      const error = (diagonal * 10 ** d) / 100;
      if (Math.log(error) < low || Math.log(error) > high) continue;
      g.beginPath();
      g.moveTo(34, y(error));
      g.lineTo(width - 8, y(error));
      g.stroke();
      g.fillText(d < -3 ? `1e${d}%` : `${Number((10 ** d).toPrecision(1))}%`, 31, y(error) + 3);
    }
    g.textAlign = 'center';
    for (let d = 1; d <= 9; ++d) {
      if (Math.log(10 ** d) < from || Math.log(10 ** d) > to) continue;
      g.fillText(['', '10 B', '100 B', '1 kB', '10 kB', '100 kB', '1 MB', '10 MB', '100 MB', '1 GB'][d], x(10 ** d), height - 3);
    }
    if (received > 0) {
      g.fillStyle = '#7fc8ff22';
      g.fillRect(34, 6, Math.max(0, Math.min(x(received), width - 8) - 34), height - 24);
    }
    for (const [key, colour] of [['maxError', '#ffb86b'], ['rmsError', '#7fc8ff']]) {
      g.strokeStyle = colour;
      g.beginPath();
      this.#rows.forEach((row, i) => g[i ? 'lineTo' : 'moveTo'](x(row.bytes), y(row[key])));
      g.stroke();
      for (const row of this.#rows) {
        g.beginPath();
        g.arc(x(row.bytes), y(row[key]), row.index === shown ? 4.5 : 2.6, 0, 7);
        g.fillStyle = row.index <= shown ? colour : '#171b21';
        g.fill();
        g.stroke();
      }
    }
  }
}
