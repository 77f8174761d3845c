// SPDX-License-Identifier: Apache-2.0
// The scene: one camera, one or two panes, drawn only when something has changed.
import {
  Color, DirectionalLight, HemisphereLight, LineBasicMaterial, LineSegments, Mesh, MeshStandardMaterial, PerspectiveCamera,
  Scene, Vector3, WebGLRenderer, BufferGeometry, Float32BufferAttribute, Int8BufferAttribute,
} from 'three';
import { OrbitControls } from 'three/addons/controls/OrbitControls.js';
import { enableMorph } from 'nmc-decoder/three';

/** Whether WebGL is drawn by the processor here: smoothing edges makes it three times slower then. */
function isDrawnBySoftware() {
  const probe = document.createElement('canvas').getContext('webgl2', { failIfMajorPerformanceCaveat: true });
  probe?.getExtension('WEBGL_lose_context')?.loseContext();
  return !probe;
}

export class Stage {
  #canvas;
  #camera = new PerspectiveCamera(38, 1, 0.01, 100);
  #insets = { left: 0, top: 0, bottom: 0 };
  #isDirty = true;
  #frame = 0;
  #listeners = new Set();

  constructor(canvas, { wantsSmoothEdges = false } = {}) {
    this.#canvas = canvas;
    this.isSoftware = isDrawnBySoftware();
    document.body.classList.toggle('software', this.isSoftware);
    this.renderer = new WebGLRenderer({ canvas, antialias: wantsSmoothEdges || !this.isSoftware, alpha: true, powerPreference: 'high-performance' });
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
    this.renderer.autoClear = false;
    this.left = this.#newScene();
    this.right = this.#newScene();
    this.isSplit = false;
    this.material = enableMorph(new MeshStandardMaterial({ color: 0xc9cdd4, roughness: 0.62, metalness: 0, side: 2 }));
    this.coloured = enableMorph(new MeshStandardMaterial({ vertexColors: true, roughness: 0.75, metalness: 0, side: 2 }));
    this.plain = new MeshStandardMaterial({ color: 0xc9cdd4, roughness: 0.62, metalness: 0, side: 2 });
    this.wireMaterial = enableMorph(new LineBasicMaterial({ color: 0x0b1626, transparent: true, opacity: 0.45 }));
    this.baseMaterial = enableMorph(new LineBasicMaterial({ color: 0xffb86b }));
    this.controls = new OrbitControls(this.#camera, canvas);
    this.controls.enableDamping = !matchMedia('(prefers-reduced-motion: reduce)').matches;
    this.controls.dampingFactor = 0.12;
    this.controls.addEventListener('change', () => this.invalidate());
    this.controls.listenToKeyEvents(canvas);
    new ResizeObserver(() => this.#resize()).observe(canvas);
    this.#resize();
  }
  get camera() { return this.#camera; }
  get viewportHeight() { return this.renderer.domElement.height; }

  #newScene() {
    const scene = new Scene();
    scene.add(new HemisphereLight(0xdfe9ff, 0x39332c, 1.1));
    const key = new DirectionalLight(0xfff4e6, 2.4);
    const rim = new DirectionalLight(0xa9c8ff, 0.9);
    key.position.set(0.6, 1, 1.2);
    rim.position.set(-1, 0.3, -0.8);
    scene.userData.lights = [key, rim];
    for (const light of scene.userData.lights) {
      scene.add(light);
      scene.add(light.target);
    }
    return scene;
  }
  /** Compiles what will be drawn before the first file comes, so that none of it holds a frame later. */
  async warmUp() {
    const geometry = new BufferGeometry();
    geometry.setAttribute('position', new Float32BufferAttribute([0, 0, 0, 1, 0, 0, 0, 1, 0], 3));
    geometry.setAttribute('normal', new Int8BufferAttribute([0, 0, 127, 0, 0, 0, 127, 0, 0, 0, 127, 0], 4, true));
    geometry.setAttribute('color', new Int8BufferAttribute([0, 0, 127, 0, 0, 0, 127, 0, 0, 0, 127, 0], 4, true));
    const things = [this.material, this.coloured, this.plain].map((material) => new Mesh(geometry, material));
    things.push(...[this.wireMaterial, this.baseMaterial].map((material) => new LineSegments(geometry, material)));
    for (const thing of things) {
      thing.frustumCulled = false;
      this.left.add(thing);
    }
    await this.renderer.compileAsync(this.left, this.#camera);
    this.#render();
    for (const thing of things) this.left.remove(thing);
    geometry.dispose();
    this.invalidate();
  }
  #resize() {
    const { clientWidth, clientHeight } = this.#canvas;
    if (!clientWidth || !clientHeight) return;
    this.renderer.setSize(clientWidth, clientHeight, false);
    this.invalidate();
  }

  /** Pixels of the page that something else covers. */
  setInsets(insets) {
    this.#insets = insets;
    this.invalidate();
  }
  /** The part of a pane that nothing covers. */
  #free() {
    const { clientWidth, clientHeight } = this.#canvas;
    const { left, top, bottom } = this.#insets;
    const width = this.isSplit ? clientWidth / 2 : clientWidth - left;
    return { width: Math.max(width, 100), height: Math.max(clientHeight - top - bottom, 100) };
  }

  /**
   * Looks at a geometry of known bounds from the front, or the direction `view`, so near that its box fills what nothing
   * covers.
   */
  fit(geometry, up = '', view = null) {
    const { center, radius } = geometry.boundingSphere;
    const { min, max } = geometry.boundingBox;
    const upward = up === 'z' ? new Vector3(0, 0, 1) : new Vector3(0, 1, 0);
    const front = up === 'z' ? [0.35, -1, 0.22] : [0.35, 0.22, 1];
    const from = new Vector3(...(view ?? front)).normalize();
    const right = new Vector3().crossVectors(upward, from).normalize();
    const above = new Vector3().crossVectors(from, right);
    const { width, height } = this.#free();
    const slope = Math.tan((this.#camera.fov * Math.PI) / 360) / this.#canvas.clientHeight;
    let distance = 0;
    for (let corner = 0; corner < 8; ++corner) {
      const at = new Vector3(corner & 1 ? max.x : min.x, corner & 2 ? max.y : min.y, corner & 4 ? max.z : min.z).sub(center);
      const aside = Math.max(Math.abs(at.dot(right)) / width, Math.abs(at.dot(above)) / height);
      distance = Math.max(distance, at.dot(from) + (1.06 * aside) / slope);
    }
    this.#camera.up.copy(upward);
    this.#camera.position.copy(center).addScaledVector(from, distance);
    this.#camera.near = radius / 500;
    this.#camera.far = radius * 60;
    this.controls.target.copy(center);
    this.controls.minDistance = radius / 50;
    this.controls.maxDistance = radius * 25;
    this.controls.update();
    this.invalidate();
  }
  onFrame(listener) { this.#listeners.add(listener); }
  invalidate() {
    this.#isDirty = true;
    this.#frame ||= requestAnimationFrame(() => this.#step());
  }
  #step() {
    this.#frame = 0;
    if (!this.#isDirty) return;
    this.#isDirty = false;
    this.controls.update();
    let goesOn = false;
    for (const listener of this.#listeners) goesOn = listener() || goesOn;
    this.#render();
    if (goesOn) this.invalidate();
  }
  #render() {
    const { renderer } = this;
    const camera = this.#camera;
    const width = this.#canvas.clientWidth;
    const height = this.#canvas.clientHeight;
    const panes = this.isSplit ? [[this.left, 0], [this.right, 1]] : [[this.left, 0]];
    const paneWidth = width / panes.length;
    camera.aspect = paneWidth / height;
    const { left, top, bottom } = this.#insets;
    camera.setViewOffset(paneWidth, height, this.isSplit ? 0 : -left / 2, (bottom - top) / 2, paneWidth, height);
    renderer.setScissorTest(false);
    renderer.clear();
    renderer.setScissorTest(true);
    for (const [scene, number] of panes) {
      for (const light of scene.userData.lights) this.#aim(light);
      renderer.setViewport(number * paneWidth, 0, paneWidth, height);
      renderer.setScissor(number * paneWidth, 0, paneWidth, height);
      renderer.render(scene, camera);
    }
  }
  /** Lights stand by the camera: what is looked at is lit. */
  #aim(light) {
    light.userData.from ??= light.position.clone();
    const distance = this.#camera.position.distanceTo(this.controls.target);
    light.target.position.copy(this.controls.target);
    light.position.copy(light.userData.from).multiplyScalar(distance)
      .applyQuaternion(this.#camera.quaternion).add(this.controls.target);
    light.color ??= new Color(1, 1, 1);
  }
}
