// SPDX-License-Identifier: Apache-2.0
// The page: what is dropped, typed or clicked, and what is said about it. Query: src, compare, original, rate (kbit/s),
// from (x,y,z: whence to look), smooth (edges, also where the processor draws).
import { NMCLoader } from 'nmc-decoder/three';
import { piecesOf } from 'nmc-decoder';

import { Chart } from './chart.js';
import { Stage } from './stage.js';
import { bytesText, countText, errorText, lengthText, shareText } from './texts.js';
import { ReceivedBytes, throttled, throttledFetch } from './throttle.js';
import { View } from './view.js';

const $ = (id) => document.getElementById(id);
const query = new URLSearchParams(location.search);
const stage = new Stage($('canvas'), { wantsSmoothEdges: query.has('smooth') });
const loader = new NMCLoader().setRenderer(stage.renderer).setWorkerLimit(2)
  .setOptions({ keepDecoder: true, uploadBytesPerFrame: 1 << 20 }).preload();
const view = new View(stage, showLegend);
const chart = new Chart($('chart'), (index) => pick(index));
const rate = () => Number($('network').value);

/** What is shown: the live stream, and a prefix of it while the sliders are not at their ends. */
let session = null;
let original = null;  // { worker, name, measure }
let sequence = 0;
/** For scripts that watch the page. */
const state = { events: [], get geometry() { return session?.geometry ?? null; }, get loader() { return loader; }, view, stage };
window.nmcViewer = state;
const record = (type, detail = {}) => state.events.push({ type, time: performance.now(), ...detail });

// ---- messages ----

function say([title, text], isNote = false) {
  const box = $('message');
  box.className = isNote ? 'note' : '';
  box.children[0].textContent = title;
  box.children[1].textContent = text;
  box.hidden = false;
  record('message', { title, text });
}
$('message').children[2].addEventListener('click', () => { $('message').hidden = true; });

function showLegend(legend) {
  $('legend').hidden = !legend;
  if (!legend) return;
  const units = session?.geometry.header.units ?? '';
  $('legend-bar').className = legend.kind;
  $('legend-low').textContent = legend.low;
  $('legend-high').textContent = legend.length === undefined ? legend.high
    : `${legend.kind === 'signed' ? 'outward ' : '≥ '}${lengthText(legend.length, units)}` +
      (legend.rms === undefined ? '' : ` · RMS ${shareText(legend.rms, session.geometry.header.diagonal)}`);
  record('legend', { text: $('legend-high').textContent });
}

// ---- streams ----

function close() {
  if (!session) return;
  view.clear();
  session.preview?.dispose();
  session.geometry?.dispose();
  session = null;
}

/** `open()` gives a fresh iterable of pieces, or a URL, each time the stream is wanted. */
async function show(name, open) {
  const mine = ++sequence;
  close();
  $('message').hidden = true;
  $('drop').hidden = true;
  $('name').textContent = name;
  $('status').textContent = 'opening …';
  record('open', { name });
  const received = new ReceivedBytes();
  const keep = async function* (pieces) {
    for await (const piece of pieces) {
      received.push(piece);
      yield piece;
    }
  };
  session = { name, open, received, geometry: null, preview: null, shown: -1 };
  const fresh = session;
  try {
    const { source, options } = open(keep);
    const geometry = await loader.open(source, {
      ...options,
      onProgress: (loaded) => { if (fresh === session) progress(loaded); },
    });
    if (mine !== sequence) return geometry.dispose();
    session.geometry = geometry;
    geometry.addEventListener('layer', () => { if (fresh === session) layerCame(); });
    geometry.addEventListener('retry', ({ loaded }) => {
      record('retry', { loaded });
      if (fresh === session) say(['The connection broke.', `Asking for the rest from byte ${loaded} on …`], true);
    });
    geometry.addEventListener('complete', () => { if (fresh === session) completed(); });
    geometry.addEventListener('error', ({ error }) => { if (fresh === session) failed(error); });
    view.show(geometry);
    $('panel').hidden = false;
    document.body.classList.add('loaded');
    clearPanel();
    refit();
    $('bytes').max = String(geometry.header.streamBytes);
    $('level').max = String(geometry.layers.at(-1).level);
    chart.set({ layers: geometry.layers, diagonal: geometry.header.diagonal, shown: 0, received: 0 });
    layerCame();
    if (geometry.isComplete) completed();
    if (geometry.error) failed(geometry.error);
    if (original) view.measure = original.measure;
  } catch (error) {
    if (mine === sequence) failed(Object.assign(error, { firstBytes: received.take(8) }));
  }
}

function progress(loaded) {
  const { geometry } = session;
  if (!geometry) return;
  if (!$('message').hidden && $('message').className === 'note') $('message').hidden = true;
  chart.set({ received: loaded });
  const total = geometry.header.streamBytes;
  if (!geometry.isComplete) $('status').textContent = `${bytesText(loaded)} of ${bytesText(total)}`;
}

function layerCame() {
  const { geometry } = session;
  record('layer', { index: geometry.layer.index, bytes: geometry.receivedBytes, triangles: geometry.layer.triangles });
  if (!session.preview) describe(geometry);
}

function completed() {
  const { geometry } = session;
  $('status').textContent = bytesText(geometry.header.streamBytes);
  chart.set({ received: geometry.header.streamBytes });
  record('complete', { hash: geometry.positionHash });
}

function failed(error) {
  const hasMesh = Boolean(session?.geometry?.layer);
  say(errorText(error, hasMesh));
  $('status').textContent = hasMesh ? `${bytesText(session.geometry.receivedBytes)}, not complete` : '';
  record('error', { code: error.code });
  if (!hasMesh) {
    close();
    $('drop').hidden = false;
    $('panel').hidden = true;
    $('name').textContent = 'nmc viewer';
  }
}

/** The figures of what is on the screen. */
function describe(geometry) {
  const { layer, header } = geometry;
  session.shown = layer.index;
  $('figure-triangles').textContent = countText(layer.triangles);
  $('figure-bytes').textContent = bytesText(layer.bytes);
  $('figure-error').textContent = shareText(layer.rmsError, header.diagonal);
  $('figure-max').textContent = lengthText(layer.maxError, header.units);
  $('bytes').value = String(layer.bytes);
  $('bytes-out').textContent = bytesText(layer.bytes);
  $('level').value = String(layer.level);
  $('level-out').textContent = `${layer.level} of ${geometry.layers.at(-1).level}`;
  chart.set({ shown: layer.index });
  if (stage.isSplit) $('label-left').textContent = `nmc · ${bytesText(layer.bytes)} · ${countText(layer.triangles)} triangles`;
}

/** Shows layer `index` of what has arrived; the last one that has is the live stream itself. */
async function pick(index) {
  const here = session;
  if (!here?.geometry) return;
  const live = here.geometry;
  const wanted = Math.max(0, Math.min(index, live.layer.index));
  const number = here.picks = (here.picks ?? 0) + 1;
  if (wanted === here.shown) return describe(here.preview ?? live);
  let next = live;
  if (wanted < live.layer.index) {
    next = await loader.open(here.received.take(live.layers[wanted].bytes), { goal: { maxLayer: wanted } });
    await next.refineTo({ layer: wanted }).catch(() => {});
  }
  if (here !== session || number !== here.picks) return next === live ? undefined : next.dispose();
  const before = here.preview;
  here.preview = next === live ? null : next;
  view.show(next);
  before?.dispose();
  describe(next);
  record('pick', { index: wanted });
}
const lastRow = (condition) => {
  const rows = session?.geometry?.layers ?? [];
  return Math.max(0, rows.findLastIndex(condition));
};
$('bytes').addEventListener('input', ({ target }) => {
  $('bytes-out').textContent = bytesText(Number(target.value));
  pick(lastRow((row) => row.bytes <= Number(target.value)));
});
$('level').addEventListener('input', ({ target }) => pick(lastRow((row) => row.level <= Number(target.value))));

// ---- the right pane and the original ----

/** The panel covers the bottom of a small or split screen, and else the left side: the surface goes beside it. */
function clearPanel() {
  const panel = $('panel').getBoundingClientRect();
  const isBelow = panel.width > 0.6 * innerWidth;
  const above = stage.isSplit ? $('label-left') : document.querySelector('header');
  stage.setInsets({
    top: above.getBoundingClientRect().bottom, left: isBelow ? 0 : panel.right,
    bottom: isBelow && panel.height > 0 ? innerHeight - panel.top : 0,
  });
}
new ResizeObserver(clearPanel).observe($('panel'));
addEventListener('resize', clearPanel);

function setSplit(isSplit) {
  stage.isSplit = isSplit;
  document.body.classList.toggle('split', isSplit);
  clearPanel();
}

async function compare(name, pieces) {
  for (const id of ['divider', 'label-left', 'label-right']) $(id).hidden = false;
  setSplit(true);
  const label = $('label-right');
  stage.right.userData.root?.removeFromParent();
  if (session?.geometry) describe(session.preview ?? session.geometry);
  clearPanel();
  refit();
  try {
    const { readGlb } = await import('./compare.js');
    const glb = await readGlb(pieces, (bytes) => { label.textContent = `${name}: ${bytesText(bytes)}, nothing to show yet`; });
    glb.root.traverse((object) => {
      if (!object.isMesh) return;
      if (!object.geometry.attributes.normal) object.geometry.computeVertexNormals();
      object.material = stage.plain;
    });
    stage.right.userData.root = glb.root;
    stage.right.add(glb.root);
    label.textContent = `${glb.kind} · ${bytesText(glb.bytes)} · ${countText(glb.triangles)} triangles`;
    record('compared', { bytes: glb.bytes, triangles: glb.triangles, kind: glb.kind });
    stage.invalidate();
  } catch (error) {
    label.textContent = `${name}: ${error.message}`;
    record('compare-failed', { message: error.message });
  }
}
function queriedView() {
  const view = (query.get('from') ?? '').split(',').map(Number);
  return view.length === 3 && view.every(Number.isFinite) && Math.hypot(...view) > 0 ? view : null;
}
function refit() {
  const geometry = session?.geometry;
  if (geometry) stage.fit(geometry, geometry.header.up, queriedView());
}

function useOriginal(name, buffer) {
  original?.worker.terminate();
  const worker = new Worker(new URL('./heat-worker.js', import.meta.url), { type: 'module' });
  const waiting = new Map();
  let count = 0;
  let loaded;
  const ready = new Promise((resolve) => { loaded = resolve; });
  worker.onmessage = ({ data }) => {
    if (data.type === 'original') {
      record('original', { triangles: data.triangles });
      loaded();
    } else if (data.type === 'distances') {
      waiting.get(data.request)?.resolve(data);
    } else if (data.request === undefined) {
      say(['The original cannot be read.', data.message]);
    } else {
      waiting.get(data.request)?.reject(new Error(data.message));
    }
    waiting.delete(data.request);
  };
  const measure = async (positions) => {
    await ready;
    return new Promise((resolve, reject) => {
      const request = ++count;
      waiting.set(request, { resolve, reject });
      worker.postMessage({ type: 'measure', request, positions });
    });
  };
  original = { worker, name, measure };
  worker.postMessage({ type: 'original', buffer }, [buffer]);
  const button = document.querySelector('[data-overlay="heat"]');
  button.disabled = false;
  button.title = `Distance to ${name}`;
  view.measure = measure;
  chooseOverlay('heat');
}

// ---- sources ----

const nameOf = (url) => decodeURIComponent(new URL(url, location.href).pathname.split('/').pop() || url);
function showUrl(url) {
  show(nameOf(url), (keep) => ({
    source: url,
    options: {
      fetch: async (address, init) => {
        const response = await throttledFetch(rate)(address, init);
        if (!response.ok || !response.body) return response;
        return new Response(tee(response, keep), { status: response.status, headers: response.headers });
      },
    },
  }));
}
/** The body of a response, each piece of which `keep` has seen. */
function tee(response, keep) {
  const reader = response.body.getReader();
  const pieces = keep((async function* () {
    for (let part; !(part = await reader.read()).done;) yield part.value;
  })());
  return new ReadableStream({
    async pull(controller) {
      const { done, value } = await pieces.next();
      if (done) controller.close();
      else controller.enqueue(value);
    },
    cancel: (reason) => reader.cancel(reason).catch(() => {}),
  }, { highWaterMark: 0 });
}
const readingOf = (file) => throttled(piecesOf(file.stream(), {}, new AbortController().signal), rate);

async function take(files) {
  const kindOf = (file) => file.name.toLowerCase().split('.').pop();
  const streams = files.filter((file) => !['ply', 'glb'].includes(kindOf(file)));
  if (streams.length > 0) {
    const file = streams[0];
    await show(file.name, (keep) => ({ source: keep(readingOf(file)), options: {} }));
  }
  for (const file of files) {
    if (kindOf(file) === 'ply') useOriginal(file.name, await file.arrayBuffer());
    if (kindOf(file) === 'glb') compare(file.name, readingOf(file));
  }
}
$('file').addEventListener('change', ({ target }) => take([...target.files]));
$('address').addEventListener('submit', (event) => {
  event.preventDefault();
  if ($('url').value.trim()) showUrl($('url').value.trim());
});
for (const type of ['dragenter', 'dragover']) {
  addEventListener(type, (event) => {
    event.preventDefault();
    document.body.classList.add('dragging');
  });
}
for (const type of ['dragleave', 'drop']) {
  addEventListener(type, (event) => {
    event.preventDefault();
    if (type === 'drop' || !event.relatedTarget) document.body.classList.remove('dragging');
    if (type === 'drop') take([...event.dataTransfer.files]);
  });
}

// ---- controls ----

function chooseOverlay(overlay) {
  for (const button of $('overlays').children) button.classList.toggle('on', button.dataset.overlay === overlay);
  view.setOverlay(overlay);
}
$('overlays').addEventListener('click', ({ target }) => {
  if (target.dataset.overlay && !target.disabled) chooseOverlay(target.dataset.overlay);
});
function toggle(id, action) {
  $(id).addEventListener('click', () => {
    const isOn = $(id).getAttribute('aria-pressed') !== 'true';
    $(id).setAttribute('aria-pressed', String(isOn));
    action(isOn);
  });
}
toggle('wire', (isOn) => view.setLines('wire', isOn));
toggle('base', (isOn) => view.setLines('base', isOn));
toggle('pause', (isOn) => (isOn ? session?.geometry?.pause() : session?.geometry?.resume()));
$('fit').addEventListener('click', refit);
$('again').addEventListener('click', () => {
  if (session) show(session.name, session.open);
  $('pause').setAttribute('aria-pressed', 'false');
});
$('home').addEventListener('click', () => {
  ++sequence;
  close();
  setSplit(false);
  for (const id of ['divider', 'label-left', 'label-right', 'panel', 'message']) $(id).hidden = true;
  $('drop').hidden = false;
  $('name').textContent = 'nmc viewer';
  $('status').textContent = '';
});

const KEYS = {
  w: () => $('wire').click(), b: () => $('base').click(), f: refit, ' ': () => $('pause').click(), r: () => $('again').click(),
  '[': () => pick((session?.shown ?? 0) - 1), ']': () => pick((session?.shown ?? 0) + 1),
  1: () => chooseOverlay('plain'), 2: () => chooseOverlay('levels'), 3: () => chooseOverlay('offsets'),
  4: () => chooseOverlay('off-normal'), 5: () => { if (original) chooseOverlay('heat'); },
  '+': () => zoom(0.85), '=': () => zoom(0.85), '-': () => zoom(1 / 0.85),
};
function zoom(factor) {
  const { controls, camera } = stage;
  camera.position.sub(controls.target).multiplyScalar(factor).add(controls.target);
  controls.update();
  stage.invalidate();
}
addEventListener('keydown', (event) => {
  if (event.ctrlKey || event.metaKey || event.altKey || /^(INPUT|SELECT|BUTTON)$/.test(event.target.tagName)) return;
  const action = KEYS[event.key.toLowerCase()];
  if (!action || !session) return;
  event.preventDefault();
  action();
});

// ---- start ----

async function listSamples() {
  const response = await fetch('./samples.json').catch(() => null);
  if (!response?.ok) return;
  const samples = await response.json().catch(() => []);
  for (const { name, url, compare: other } of samples) {
    const item = document.createElement('li');
    const button = document.createElement('button');
    button.textContent = name;
    button.addEventListener('click', () => {
      showUrl(url);
      if (other) compareUrl(other);
    });
    item.append(button);
    $('samples').append(item);
  }
}
async function compareUrl(url) {
  const response = await throttledFetch(rate)(url);
  if (response.ok) compare(nameOf(url), piecesOf(response, {}, new AbortController().signal));
}

/** Fonts and layout of what appears with the first mesh: they take longer than a frame. */
function warmUpPage() {
  const parts = ['panel', 'legend', 'label-left', 'label-right', 'message'].map($);
  document.body.classList.add('warming');
  for (const part of parts) part.hidden = false;
  $('status').textContent = '10.0 kB of 100 kB';
  $('panel').getBoundingClientRect();
  for (const part of parts) part.hidden = true;
  $('status').textContent = '';
  document.body.classList.remove('warming');
}

warmUpPage();
await stage.warmUp();
record('ready');
const queriedRate = Number(query.get('rate'));
if (queriedRate > 0) {
  const choices = [...$('network').options].map(({ value }) => value);
  if (!choices.includes(String(queriedRate))) $('network').add(new Option(`${queriedRate} kbit/s`, String(queriedRate)));
  $('network').value = String(queriedRate);
}
if (query.get('src')) showUrl(query.get('src'));
else listSamples();
if (query.get('compare')) compareUrl(query.get('compare'));
if (query.get('original')) {
  const answer = await fetch(query.get('original'));
  if (answer.ok) useOriginal(nameOf(query.get('original')), await answer.arrayBuffer());
}
