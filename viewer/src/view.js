// SPDX-License-Identifier: Apache-2.0
// One progressive mesh on the stage, with its overlays.
import { BufferGeometry, LineSegments } from 'three';
import { NMCMesh } from 'nmc-decoder/three';

import { baseIndices, heatColours, levelColours, offNormalColours, offsetColours, wireIndices } from './overlays.js';

export class View {
  #stage;
  #lines = {};
  #heat = null;
  #request = 0;
  overlay = 'plain';
  legend = null;

  /** `measure(positions)` resolves to { distances, rms, largest }; null while there is no original. */
  constructor(stage, onLegend) {
    this.#stage = stage;
    this.onLegend = onLegend;
    this.measure = null;
    this.mesh = null;
    this.lineKinds = new Set();
    stage.onFrame(() => this.mesh?.geometry.isMorphing ?? false);
  }
  get geometry() { return this.mesh?.geometry ?? null; }

  /** Shows another geometry; the one before is the caller's to dispose of. */
  show(geometry) {
    this.clear();
    this.mesh = new NMCMesh(geometry, this.#stage.material);
    this.#stage.left.add(this.mesh);
    this.#onLayer = () => this.#refresh();
    geometry.addEventListener('layer', this.#onLayer);
    this.#refresh();
  }
  #onLayer = null;
  clear() {
    ++this.#request;
    if (!this.mesh) return;
    this.mesh.geometry.removeEventListener('layer', this.#onLayer);
    this.mesh.removeFromParent();
    for (const kind of Object.keys(this.#lines)) this.#dropLines(kind);
    this.mesh = null;
    this.#tell(null);
    this.#stage.invalidate();
  }

  setOverlay(overlay) {
    this.overlay = overlay;
    this.#colour();
  }
  setLines(kind, isOn) {
    if (isOn) this.lineKinds.add(kind);
    else this.lineKinds.delete(kind);
    this.#drawLines();
  }

  #refresh() {
    const { geometry } = this;
    geometry.userData.streamColour = geometry.attributes.color ?? null;
    this.#drawLines();
    this.#colour();
    this.#stage.invalidate();
  }
  #tell(legend) {
    this.legend = legend;
    this.onLegend(legend);
  }

  async #colour() {
    const { geometry } = this;
    if (!geometry?.layer) return;
    const request = ++this.#request;
    const { layer } = geometry;
    const use = (attribute, legend) => {
      if (request !== this.#request || geometry.layer !== layer) return;
      if (attribute) geometry.setAttribute('color', attribute);
      else geometry.deleteAttribute('color');
      this.mesh.material = attribute ? this.#stage.coloured : this.#stage.material;
      this.#tell(legend);
      this.#stage.invalidate();
    };
    const plain = () => use(geometry.userData.streamColour, null);
    try {
      if (this.overlay === 'plain') {
        plain();
      } else if (this.overlay === 'levels') {
        use(levelColours(geometry), { kind: 'levels', low: `level ${layer.level}`, high: 'base' });
      } else if (this.overlay === 'heat') {
        if (!this.measure) return plain();
        this.#tell({ kind: 'heat', low: 'measuring …', high: '' });
        const { distances, rms, largest } = await this.measure(geometry.attributes.position.array);
        const scale = Math.max(Math.min(largest, 3.5 * rms), 1e-12 * geometry.header.diagonal);
        use(heatColours(distances, scale), { kind: 'heat', low: '0', length: scale, rms, largest });
      } else {
        const offsets = await geometry.readOffsets();
        if (offsets.normal.length !== geometry.attributes.position.count) return;
        if (this.overlay === 'offsets') {
          const { largest, attribute } = offsetColours(offsets);
          use(attribute, { kind: 'signed', low: 'inward', length: largest });
        } else {
          const { count, attribute } = offNormalColours(offsets);
          const share = (100 * count) / offsets.normal.length;
          use(attribute, { kind: 'flag', low: 'along the normal', high: `sideways too: ${share.toPrecision(2)} %` });
        }
      }
    } catch (error) {
      if (request === this.#request) {
        plain();
        this.#tell({ kind: 'heat', low: error.message, high: '' });
      }
    }
  }

  #drawLines() {
    for (const kind of Object.keys(this.#lines)) this.#dropLines(kind);
    if (!this.geometry?.index) return;
    for (const kind of this.lineKinds) {
      const lines = new BufferGeometry();
      lines.setIndex(kind === 'wire' ? wireIndices(this.geometry) : baseIndices(this.geometry));
      for (const name of ['position', 'nmcStart']) {
        if (this.geometry.attributes[name]) lines.setAttribute(name, this.geometry.attributes[name]);
      }
      lines.boundingSphere = this.geometry.boundingSphere;
      const material = kind === 'wire' ? this.#stage.wireMaterial : this.#stage.baseMaterial;
      const object = new LineSegments(lines, material);
      object.onBeforeRender = this.mesh.onBeforeRender;
      object.renderOrder = kind === 'wire' ? 1 : 2;
      this.#lines[kind] = object;
      this.mesh.add(object);
    }
    // Lines lie on the surface: it steps back a little.
    for (const material of [this.#stage.material, this.#stage.coloured]) {
      const offset = this.lineKinds.size > 0;
      if (material.polygonOffset !== offset) Object.assign(material, { polygonOffset: offset, polygonOffsetFactor: 1, polygonOffsetUnits: 1 });
    }
    this.#stage.invalidate();
  }
  /** Their vertices belong to the mesh, so only the indices are freed. */
  #dropLines(kind) {
    const { geometry } = this.#lines[kind];
    for (const name of Object.keys(geometry.attributes)) geometry.deleteAttribute(name);
    geometry.dispose();
    this.#lines[kind].removeFromParent();
    delete this.#lines[kind];
  }
}
