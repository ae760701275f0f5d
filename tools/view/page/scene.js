// The 3-D scene: world W, z up, in metres.
import {
  AxesHelper, BufferAttribute, BufferGeometry, Color, DynamicDrawUsage, GridHelper, Group, Line,
  LineBasicMaterial, LineSegments, Mesh, MeshBasicMaterial, PerspectiveCamera, Points,
  PointsMaterial, Quaternion, Scene, SphereGeometry, Vector3, WebGLRenderer,
} from 'three';
import {OrbitControls} from 'three/examples/jsm/controls/OrbitControls.js';

const kFrustum_m = 0.25, kKeyframesDrawn = 1500, kSigmas = 3;

function colour(name) {
  return new Color(getComputedStyle(document.documentElement).getPropertyValue(name).trim());
}

// False where the processor draws: smooth edges would cost it a third of its pictures.
function isQuick() {
  const probe = document.createElement('canvas').getContext(
      'webgl2', {failIfMajorPerformanceCaveat: true});
  if (probe !== null) probe.getExtension('WEBGL_lose_context')?.loseContext();
  return probe !== null;
}

// Floats that grow, as attributes of one geometry.
class Growing {
  constructor(object, sizes) {
    this.object = object;
    this.sizes = sizes;  // {position: 3, color: 3}
    this.count = 0;
    this.grow(1024);
  }
  grow(capacity) {
    const geometry = new BufferGeometry();
    for (const [name, size] of Object.entries(this.sizes)) {
      const array = new Float32Array(capacity * size);
      const before = this.object.geometry.getAttribute(name);
      if (this.count > 0) array.set(before.array.subarray(0, this.count * size));
      const attribute = new BufferAttribute(array, size);
      attribute.setUsage(DynamicDrawUsage);
      geometry.setAttribute(name, attribute);
    }
    this.object.geometry.dispose();
    this.object.geometry = geometry;
    this.object.frustumCulled = false;
    this.capacity = capacity;
  }
  // Room for so many more; the index of the first.
  add(more) {
    const first = this.count;
    if (first + more > this.capacity) this.grow(Math.max(2 * this.capacity, first + more));
    this.count += more;
    this.object.geometry.setDrawRange(0, this.count);
    return first;
  }
  array(name) { return this.object.geometry.getAttribute(name).array; }
  touch() {
    for (const name of Object.keys(this.sizes)) {
      this.object.geometry.getAttribute(name).needsUpdate = true;
    }
  }
  clear() {
    this.count = 0;
    this.object.geometry.setDrawRange(0, 0);
  }
}

function points(size) {
  return new Points(new BufferGeometry(), new PointsMaterial(
      {size, sizeAttenuation: false, vertexColors: true}));
}

// Corners of a camera's image at kFrustum_m, in C; the apex is 0.
function frustum(camera, size) {
  const x = size * camera.width / (2 * camera.focal[0]);
  const y = size * camera.height / (2 * camera.focal[1]);
  return [[-x, -y, size], [x, -y, size], [x, y, size], [-x, y, size]].map((c) => new Vector3(...c));
}

function frustumLines(corners, R, p, out, at) {
  const apex = p, moved = corners.map((c) => c.clone().applyQuaternion(R).add(p));
  const pairs = [];
  for (let i = 0; i < 4; ++i) pairs.push(apex, moved[i], moved[i], moved[(i + 1) % 4]);
  for (const v of pairs) at = (v.toArray(out, at), at + 3);
  return at;
}

const kGeneric = {width: 752, height: 480, focal: [460, 460], p: [0, 0, 0], q: [0, 0, 0, 1]};

export class View3d {
  constructor(canvas) {
    this.canvas = canvas;
    this.renderer = new WebGLRenderer({canvas, antialias: isQuick()});
    this.ratio = this.ratioMax = Math.min(window.devicePixelRatio, 2);
    this.scene = new Scene();
    this.camera = new PerspectiveCamera(55, 1, 0.02, 2000);
    this.camera.up.set(0, 0, 1);
    this.camera.position.set(-3.5, -3.5, 3);
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.addEventListener('change', () => { this.dirty = true; });
    this.controls.addEventListener('start', () => { this.held = true; });
    this.controls.addEventListener('end', () => { this.held = false; });
    this.follow = true;
    this.dirty = true;
    this.makeLayers();
    this.recolour();
    new ResizeObserver(() => this.resize()).observe(canvas.parentElement);
    this.resize();
  }

  makeLayers() {
    this.grid = new Group();
    this.axes = new AxesHelper(0.5);
    this.path = new LineSegments(new BufferGeometry(), new LineBasicMaterial({vertexColors: true}));
    this.pathData = new Growing(this.path, {position: 3, color: 3});
    this.pathRows = [];
    this.points = points(2.2);
    this.pointData = new Growing(this.points, {position: 3, color: 3});
    this.pointAt = new Map();
    this.pointOld = [];
    this.earlier = points(2);
    this.earlier.material.transparent = true;
    this.earlierData = new Growing(this.earlier, {position: 3, color: 3});
    this.keyframes = new LineSegments(new BufferGeometry(),
                                      new LineBasicMaterial({transparent: true, opacity: 0.55}));
    this.keyframeData = new Growing(this.keyframes, {position: 3});
    this.body = new Group();
    this.body.visible = false;
    this.bodyAxes = new AxesHelper(0.3);
    this.frustums = new LineSegments(new BufferGeometry(), new LineBasicMaterial());
    this.body.add(this.bodyAxes, this.frustums);
    this.sigma = new Mesh(new SphereGeometry(1, 20, 14), new MeshBasicMaterial(
        {transparent: true, opacity: 0.22, depthWrite: false}));
    this.sigma.visible = false;
    this.earth = new Group();
    this.earth.visible = false;
    this.fused = new Line(new BufferGeometry(), new LineBasicMaterial());
    this.fusedData = new Growing(this.fused, {position: 3});
    this.fixes = points(5);
    this.fixData = new Growing(this.fixes, {position: 3, color: 3});
    this.earth.add(this.fused, this.fixes);
    this.layers = {
      path: [this.path], points: [this.points], earlier: [this.earlier],
      keyframes: [this.keyframes], gnss: [this.earth], grid: [this.grid, this.axes],
    };
    for (const objects of Object.values(this.layers)) {
      const layer = new Group();
      layer.add(...objects);
      this.scene.add(layer);
    }
    this.scene.add(this.body, this.sigma);
    this.setCameras([]);
  }

  resize() {
    const {clientWidth: width, clientHeight: height} = this.canvas.parentElement;
    if (width === 0 || height === 0) return;
    this.renderer.setPixelRatio(this.ratio);
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    this.dirty = true;
  }

  // Slow machines draw fewer pixels.
  setRatio(ratio) {
    this.ratio = Math.min(this.ratioMax, Math.max(0.4, ratio));
    this.resize();
  }

  recolour() {
    this.colours = {};
    for (const name of ['good', 'warn', 'bad', 'accent', 'point', 'old', 'earlier', 'grid', 'line',
                        's2', 'text', 'soft']) {
      this.colours[name] = colour('--' + name);
    }
    this.renderer.setClearColor(colour('--space'));
    this.grid.clear();
    const grid = new GridHelper(40, 40, this.colours.soft, this.colours.line);
    grid.rotation.x = Math.PI / 2;
    this.grid.add(grid);
    this.keyframes.material.color = this.colours.accent;
    this.frustums.material.color = this.colours.text;
    this.fused.material.color = this.colours.s2;
    this.sigma.material.color = this.colours.accent;
    const paths = this.pathRows;
    this.pathData.clear();
    this.pathRows = [];
    for (const row of paths) this.addPlace(row);
    this.pathData.touch();
    for (const [id, at] of this.pointAt) this.paintPoint(at, this.pointOld[at]);
    this.pointData.touch();
    const earlier = this.earlierData.array('color');
    for (let i = 0; i < this.earlierData.count; ++i) this.colours.earlier.toArray(earlier, 3 * i);
    this.earlierData.touch();
    this.dirty = true;
  }

  ofConfidence(confidence) {
    const {good, warn, bad} = this.colours;
    return confidence >= 0.6 ? good : confidence >= 0.3 ? warn : bad;
  }

  // ---- what is told ----

  forget() {
    for (const data of [this.pathData, this.pointData, this.keyframeData, this.fusedData,
                        this.fixData]) {
      data.clear();
    }
    this.pathRows = [];
    this.pointAt.clear();
    this.pointOld = [];
    this.dirty = true;
  }

  reset() {
    this.forget();
    this.earlierData.clear();
    this.body.visible = this.sigma.visible = this.earth.visible = false;
  }

  setCameras(cameras) {
    this.cameraList = cameras.length > 0 ? cameras : [];
    const shown = this.cameraList;
    const array = new Float32Array(Math.max(1, shown.length) * 16 * 3);
    let at = 0;
    for (const camera of shown) {
      at = frustumLines(frustum(camera, kFrustum_m), new Quaternion(...camera.q),
                        new Vector3(...camera.p), array, at);
    }
    this.frustums.geometry.dispose();
    this.frustums.geometry = new BufferGeometry();
    this.frustums.geometry.setAttribute('position', new BufferAttribute(array, 3));
    this.frustums.visible = shown.length > 0;
    this.keyframeCorners = frustum(shown[0] || kGeneric, 0.08);
  }

  // row: x, y, z, confidence, segment
  addPlace(row) {
    const last = this.pathRows[this.pathRows.length - 1];
    this.pathRows.push(row);
    if (!last || last[4] !== row[4]) return;
    const at = 3 * this.pathData.add(2), position = this.pathData.array('position');
    const paint = this.ofConfidence(row[3]), color = this.pathData.array('color');
    position.set([last[0], last[1], last[2], row[0], row[1], row[2]], at);
    paint.toArray(color, at);
    paint.toArray(color, at + 3);
  }

  addPath(rows, all) {
    if (all) {
      this.pathData.clear();
      this.pathRows = [];
    }
    for (const row of rows) this.addPlace(row);
    this.pathData.touch();
    this.dirty = true;
  }

  paintPoint(at, old) {
    this.pointOld[at] = old;
    (old ? this.colours.old : this.colours.point).toArray(this.pointData.array('color'), 3 * at);
  }

  // ids and places side by side
  addPoints(ids, rows, olds) {
    for (let i = 0; i < ids.length; ++i) {
      let at = this.pointAt.get(ids[i]);
      if (at === undefined) {
        at = this.pointData.add(1);
        this.pointAt.set(ids[i], at);
      }
      this.pointData.array('position').set(rows[i], 3 * at);
      this.paintPoint(at, olds[i] !== 0);
    }
    this.pointData.touch();
    this.dirty = true;
  }

  // What was told before the pose jumped may be elsewhere now.
  jump() {
    for (const at of this.pointAt.values()) this.paintPoint(at, true);
    this.pointData.touch();
  }

  setEarlier(rows) {
    this.earlierData.clear();
    this.earlierData.add(rows.length);
    rows.forEach((row, i) => {
      this.earlierData.array('position').set(row, 3 * i);
      this.colours.earlier.toArray(this.earlierData.array('color'), 3 * i);
    });
    this.earlierData.touch();
    this.dirty = true;
  }

  // Before the pose is localised in it, W is another frame than that map's.
  setEarlierCertain(certain) {
    const opacity = certain ? 1 : 0.3;
    if (this.earlier.material.opacity === opacity) return;
    this.earlier.material.opacity = opacity;
    this.dirty = true;
  }

  // row: p, q
  addKeyframes(rows, all) {
    if (all || this.keyframeData.count > 16 * kKeyframesDrawn) this.keyframeData.clear();
    const camera = this.cameraList[0] || kGeneric;
    const R_BC = new Quaternion(...camera.q), p_BC = new Vector3(...camera.p);
    for (const row of rows.slice(-kKeyframesDrawn)) {
      const R_WB = new Quaternion(row[3], row[4], row[5], row[6]);
      const p = p_BC.clone().applyQuaternion(R_WB).add(new Vector3(row[0], row[1], row[2]));
      const at = this.keyframeData.add(16);
      frustumLines(this.keyframeCorners, R_WB.multiply(R_BC), p,
                   this.keyframeData.array('position'), 3 * at);
    }
    this.keyframeData.touch();
    this.dirty = true;
  }

  addFused(rows, all, T_WE) {
    if (all) this.fusedData.clear();
    for (const row of rows) {
      const at = this.fusedData.add(1);
      this.fusedData.array('position').set([row[0], row[1], row[2]], 3 * at);
    }
    this.fusedData.touch();
    this.earth.visible = T_WE !== null;
    if (T_WE === null) return;
    this.earth.position.set(...T_WE.p);
    this.earth.quaternion.set(...T_WE.q);
    this.dirty = true;
  }

  addFixes(rows, all) {
    if (all) this.fixData.clear();
    for (const row of rows) {
      const at = this.fixData.add(1);
      this.fixData.array('position').set([row[0], row[1], row[2]], 3 * at);
      (row[3] === 0 ? this.colours.good : this.colours.bad).toArray(
          this.fixData.array('color'), 3 * at);
    }
    this.fixData.touch();
    this.dirty = true;
  }

  setPose(state) {
    const before = this.body.position.clone(), first = !this.body.visible;
    this.body.visible = true;
    this.body.position.set(...state.p);
    this.body.quaternion.set(...state.q);
    if (state.sigma_p) {
      this.sigma.visible = true;
      this.sigma.position.copy(this.body.position);
      this.sigma.scale.set(...state.sigma_p.map((s) => Math.max(1e-4, kSigmas * s)));
    }
    if (this.follow) {
      const moved = first ? this.body.position.clone().sub(this.controls.target)
                          : this.body.position.clone().sub(before);
      this.controls.target.add(moved);
      this.camera.position.add(moved);
    }
    this.dirty = true;
  }

  // ---- where from ----

  setFollow(on) {
    this.follow = on;
    if (!on || !this.body.visible) return;
    const moved = this.body.position.clone().sub(this.controls.target);
    this.controls.target.add(moved);
    this.camera.position.add(moved);
    this.dirty = true;
  }

  lookFromAbove() {
    const away = this.camera.position.distanceTo(this.controls.target);
    this.camera.position.copy(this.controls.target).add(new Vector3(0, -1e-3 * away, away));
    this.dirty = true;
  }

  // Path and keyframes, or what there is of points.
  fit() {
    const places = this.pathRows.length > 1 ? this.pathRows : [...this.pointAt.values()].map(
        (at) => this.pointData.array('position').slice(3 * at, 3 * at + 3));
    if (places.length === 0) return;
    const low = new Vector3(Infinity, Infinity, Infinity), high = low.clone().negate();
    for (const p of places) {
      const v = new Vector3(p[0], p[1], p[2]);
      low.min(v);
      high.max(v);
    }
    const centre = low.clone().add(high).multiplyScalar(0.5);
    const radius = Math.max(0.5, high.distanceTo(low) / 2);
    const away = this.camera.position.clone().sub(this.controls.target).normalize();
    this.controls.target.copy(centre);
    this.camera.position.copy(centre).addScaledVector(away, 2.1 * radius);
    this.dirty = true;
  }

  show(layer, on) {
    for (const object of this.layers[layer]) object.parent.visible = on;
    this.dirty = true;
  }

  // True: something was drawn.
  draw() {
    this.controls.update();
    if (!this.dirty) return false;
    this.dirty = false;
    this.renderer.render(this.scene, this.camera);
    return true;
  }
}
