// SPDX-License-Identifier: Apache-2.0
// Rendering of one run by three.js: bodies, environment and visual fields.
'use strict';

class Stage {
  constructor(run, frames, canvas) {
    this.run = run, this.frames = frames, this.look = 'shaded', this.shown = -1, this.turn = 0;
    this.renderer = new THREE.WebGLRenderer({canvas, antialias: true, preserveDrawingBuffer: true});
    this.renderer.setPixelRatio(window.devicePixelRatio || 1);
    this.renderer.shadowMap.enabled = true, this.renderer.shadowMap.type = THREE.PCFSoftShadowMap;
    this.renderer.gammaOutput = true, this.renderer.gammaFactor = 2.2;
    this.scene = new THREE.Scene();
    this.scene.background = new THREE.Color(0xf4f4f2);
    this.scene.add(new THREE.HemisphereLight(0xffffff, 0xb0a898, 0.8));
    this.sun = new THREE.DirectionalLight(0xffffff, 0.7);
    this.sun.castShadow = true, this.sun.shadow.mapSize.set(2048, 2048);
    this.scene.add(this.sun, this.sun.target);
    this.marks = new THREE.LineSegments(new THREE.BufferGeometry(), new THREE.LineBasicMaterial({vertexColors: THREE.VertexColors}));
    this.marks.frustumCulled = this.marks.visible = false;
    this.scene.add(this.marks);
    this.moving = [], this.deforming = [], this.parts = [], this.scales = {};  // of visual fields: the value at the end of the colour scale
  }

  async prepare() {
    for (const [o, object] of this.run.environment.entries()) {
      const moves = this.run.moving ? this.run.moving.includes(o) : object.moves;  // pages of older versions lack "moving"
      const x = await positions(object.points, object.count, moves ? [0, 0, 0] : origin);
      const faces = await unpacked(object.faces, 4 * object.face_count, 4, 4);
      const geometry = new THREE.BufferGeometry();
      geometry.setAttribute('position', new THREE.BufferAttribute(x, 3));
      geometry.setIndex(new THREE.BufferAttribute(trianglesOf(faces), 1));
      const mesh = new THREE.Mesh(geometry, new THREE.MeshStandardMaterial(
          {color: linear(object.colour), roughness: 0.9, side: THREE.DoubleSide, flatShading: true}));
      mesh.castShadow = mesh.receiveShadow = true;
      if (moves) mesh.matrixAutoUpdate = false, this.moving.push(mesh);
      if (object.deforms) mesh.frustumCulled = false, this.deforming.push(mesh);
      this.scene.add(mesh);
    }
    this.light();
  }

  // The bounding box of the bodies over all frames, without the frames of an explosion if the run diverged.
  box() {
    const box = new THREE.Box3(), frames = this.run.frames, most = 10 * Math.hypot(...frames[0].points.side);
    const explodes = this.run.report.status === 'diverged';
    for (const frame of frames) {
      if (explodes && Math.hypot(...frame.points.side) > most) continue;
      const side = frame.points.side, low = frame.points.low.map((at, k) => at - origin[k]);
      box.expandByPoint(new THREE.Vector3(...low));
      box.expandByPoint(new THREE.Vector3(low[0] + side[0], low[1] + side[1], low[2] + side[2]));
    }
    return box;
  }

  light() {
    const sphere = this.box().getBoundingSphere(new THREE.Sphere()), r = 1.3 * sphere.radius || 1;
    this.sun.target.position.copy(sphere.center);
    this.sun.position.copy(sphere.center).add(new THREE.Vector3(0.5, 1.6, 0.8).multiplyScalar(2 * r));
    const camera = this.sun.shadow.camera;
    camera.left = camera.bottom = -1.5 * r, camera.right = camera.top = 1.5 * r, camera.near = 0.1 * r, camera.far = 8 * r;
    camera.updateProjectionMatrix();
    this.sun.shadow.bias = -0.0005;
  }

  // Builds the geometry of the bodies for the mesh of a frame.
  build(mesh) {
    for (const part of this.parts) this.scene.remove(part), part.geometry.dispose();
    this.parts = [], this.mesh = mesh, this.wire = null;
    this.x = new THREE.BufferAttribute(new Float32Array(3 * mesh.count), 3);
    this.colours = new THREE.BufferAttribute(new Float32Array(3 * mesh.count), 3);
    const size = this.box().getSize(new THREE.Vector3()).length() || 1;
    this.spread = Math.min(size / Math.sqrt(Math.max(mesh.count, 1)), 0.05 * size);  // approximate distance of neighbouring particles, m
    const dots = new THREE.PointsMaterial({vertexColors: THREE.VertexColors, size: 0.35 * this.spread});
    this.surface = this.add(THREE.Mesh, mesh.triangles, new THREE.MeshStandardMaterial(
        {vertexColors: THREE.VertexColors, roughness: 0.75, side: THREE.DoubleSide, polygonOffsetFactor: 1, polygonOffsetUnits: 1}));
    this.surface.castShadow = this.surface.receiveShadow = true;
    this.rods = this.add(THREE.LineSegments, mesh.lines, new THREE.LineBasicMaterial({vertexColors: THREE.VertexColors}));
    this.points = this.add(THREE.Points, null, dots);
    const used = new Uint8Array(mesh.count), loose = [];
    for (const i of mesh.triangles) used[i] = 1;
    for (const i of mesh.lines) used[i] = 1;
    used.forEach((is, i) => { if (!is) loose.push(i); });
    this.loose = this.add(THREE.Points, Uint32Array.from(loose), dots);
  }

  // Adds an object of all particles, or of those in `index`.
  add(Kind, index, material) {
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute('position', this.x), geometry.setAttribute('color', this.colours);
    if (index) geometry.setIndex(new THREE.BufferAttribute(index, 1));
    const part = new Kind(geometry, material);
    part.frustumCulled = false;
    this.scene.add(part), this.parts.push(part);
    return part;
  }

  // Shows a frame; a later call supersedes an earlier one that has not finished.
  async show(k) {
    const turn = ++this.turn;
    const deformed = this.deforming.map((object, d) => this.frames.deformed(k, d, object.geometry.attributes.position.count));
    const [mesh, x, data, ...surfaces] =
        await Promise.all([this.frames.mesh(k), this.frames.positions(k), this.dataOf(this.look, k), ...deformed]);
    if (turn !== this.turn) return;
    if (mesh !== this.mesh) this.build(mesh);
    this.x.array.set(x), this.x.needsUpdate = true;
    if (mesh.triangles.length > 0) this.surface.geometry.computeVertexNormals();
    this.data = data;
    this.paint(x);
    const wires = this.look === 'wire', particles = this.look === 'particles';
    this.surface.visible = !wires && !particles, this.points.visible = particles;
    this.rods.visible = !particles && !(this.look === 'batch' && data), this.loose.visible = !particles;
    this.surface.material.polygonOffset = this.marks.visible;  // because lines lie in the surface
    if (wires && !this.wire) this.wire = this.add(THREE.LineSegments, edgesOf(mesh), this.rods.material);
    if (this.wire) this.wire.visible = wires;
    this.deforming.forEach((object, d) => {
      const to = object.geometry.attributes.position;
      to.array.set(surfaces[d]), to.needsUpdate = true;
    });
    this.moving.forEach((object, o) => {
      const p = this.run.frames[k].poses[o];
      const t = origin.map((at, i) => p[9 + i] - at);
      object.matrix.set(p[0], p[1], p[2], t[0], p[3], p[4], p[5], t[1], p[6], p[7], p[8], t[2], 0, 0, 0, 1);
    });
    this.shown = k;
  }
  // The data of a frame that a visual field needs besides positions.
  async dataOf(look, k) {
    const frames = this.frames;
    if (look === 'strain') return this.startOf(k);
    if (look === 'residual') return frames.residuals(k);
    if (look === 'batch') return frames.batches(k);
    if (look === 'force') return frames.forces(k);
    if (look === 'contact') {
      const [touches, start] = await Promise.all([frames.touches(k), this.startOf(k)]);
      return touches && {touches, start};
    }
    if (look !== 'speed') return null;
    const beside = frames.beside(k), dt = Math.abs(frames.all[k].time - frames.all[beside].time);
    const [other, itsMesh, mesh] = await Promise.all([frames.positions(beside), frames.mesh(beside), frames.mesh(k)]);
    return {last: renumbered(other, itsMesh, mesh), dt};
  }
  async startOf(k) {
    const mesh = this.run.meshes[this.run.frames[k].mesh];
    return mesh.positions = mesh.positions || await positions(mesh.start, mesh.count);
  }

  paint(x) {
    const to = this.colours.array, {mesh, look, data} = this, values = kMeasured[look] && kMeasured[look](mesh, x, data);
    let marks = null;
    if (values) {
      this.largest = values.reduce((most, value) => Math.max(most, value), 0);
      this.most = this.scales[look] || this.largest;
      for (let i = 0; i < mesh.count; ++i) turbo(this.most > 0 ? values[i] / this.most : 0, to, 3 * i);
    } else if (mesh[look]) {
      mesh[look].forEach((number, i) => distinct(number).toArray(to, 3 * i));
    } else if (look === 'batch' && data) {
      for (let i = 0; i < mesh.count; ++i) kNoValue.toArray(to, 3 * i);
      marks = batchMarks(data, x);
    } else if (look === 'contact' && data) {
      for (let i = 0; i < mesh.count; ++i) kNoValue.toArray(to, 3 * i);
      for (const i of data.touches.particles) kContact.toArray(to, 3 * i);
      mesh.spacing = mesh.spacing || spacing(mesh, data.start) || this.spread;
      marks = normalMarks(data.touches, x, 2 * mesh.spacing);
    } else if (look === 'force' && data) {
      for (let i = 0; i < mesh.count; ++i) kNoValue.toArray(to, 3 * i);
      for (const i of data.particles) kContact.toArray(to, 3 * i);
      marks = forceMarks(data, x, this.scales.metresPerNewton);
    } else {
      this.run.bodies.forEach((body, b) => {
        const colour = linear(body.colour);
        for (let i = mesh.bodyBegin[b]; i < mesh.bodyBegin[b + 1]; ++i) colour.toArray(to, 3 * i);
      });
    }
    this.colours.needsUpdate = true;
    this.mark(marks);
  }

  // Replaces the drawn lines by these.
  mark(marks) {
    this.marks.visible = marks !== null;
    this.marks.material.depthTest = this.look !== 'force';  // forces on solids point into them
    if (!marks && !this.marks.geometry.attributes.position) return;
    this.marks.geometry.dispose(), this.marks.geometry = new THREE.BufferGeometry();
    if (!marks) return;
    this.marks.geometry.setAttribute('position', new THREE.BufferAttribute(marks.x, 3));
    this.marks.geometry.setAttribute('color', new THREE.BufferAttribute(marks.colours, 3));
  }

  render(camera) {
    const canvas = this.renderer.domElement, w = canvas.clientWidth, h = canvas.clientHeight;
    const size = this.renderer.getSize(new THREE.Vector2());
    if (size.x !== w || size.y !== h) this.renderer.setSize(w, h, false);
    this.renderer.render(this.scene, camera);
  }
}
