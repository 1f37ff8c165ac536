// SPDX-License-Identifier: Apache-2.0
// Visual fields: colours of particles, and lines that are drawn beside them.
'use strict';

function linear(colour) { return new THREE.Color(...colour).convertSRGBToLinear(); }

// The colour map Turbo (Mikhailov 2019), interpolated between seven stops.
const kTurboColour = new THREE.Color();
const kTurbo = [[48, 18, 59], [70, 134, 251], [26, 228, 182], [164, 252, 60], [251, 185, 56], [228, 70, 10], [122, 4, 3]];
function turbo(part, to, at) {
  const where = Math.min(Math.max(part, 0), 1) * (kTurbo.length - 1), k = Math.min(Math.floor(where), kTurbo.length - 2);
  for (let c = 0; c < 3; ++c) to[at + c] = (kTurbo[k][c] + (where - k) * (kTurbo[k + 1][c] - kTurbo[k][c])) / 255;
  kTurboColour.fromArray(to, at).convertSRGBToLinear().toArray(to, at);
}

// The colour of a number, with consecutive ones far apart. 0 is grey and means none.
const kDistinct = new Map();
function distinct(number) {
  if (!kDistinct.has(number)) {
    const colour = new THREE.Color(0.6, 0.6, 0.6);
    if (number > 0) colour.setHSL(0.618034 * number % 1, 0.65, 0.42 + 0.11 * (number % 3));
    kDistinct.set(number, colour.convertSRGBToLinear());
  }
  return kDistinct.get(number);
}

// The window's colours of particles without a value, and of particles in contact.
const kNoValue = linear([205 / 255, 208 / 255, 214 / 255]), kContact = linear([225 / 255, 60 / 255, 50 / 255]);

// Distance (m) of two points, given by their offsets in an array.
function distance(p, a, b) { return Math.hypot(p[a] - p[b], p[a + 1] - p[b + 1], p[a + 2] - p[b + 2]); }

// The largest |l - l0| / l0 of the edges of each particle.
function strains(mesh, x, start) {
  const values = new Float32Array(mesh.count), edges = edgesOf(mesh);
  for (let e = 0; e < edges.length; e += 2) {
    const i = edges[e], j = edges[e + 1], rest = distance(start, 3 * i, 3 * j);
    const strain = rest > 0 ? Math.abs(distance(x, 3 * i, 3 * j) - rest) / rest : 0;
    values[i] = Math.max(values[i], strain), values[j] = Math.max(values[j], strain);
  }
  return values;
}

// Speeds (m/s) by finite differences of two frames. A particle that a tear added since gets the speed of a neighbour.
function speeds(mesh, x, last, dt) {
  const values = new Float32Array(x.length / 3), added = [];
  if (!(dt > 0)) return values;
  for (let i = 0; i < values.length; ++i) {
    values[i] = Math.hypot(x[3 * i] - last[3 * i], x[3 * i + 1] - last[3 * i + 1], x[3 * i + 2] - last[3 * i + 2]) / dt;
    if (isNaN(values[i])) added.push(i);
  }
  if (added.length === 0) return values;
  const edges = edgesOf(mesh);
  for (let e = 0; e < edges.length; e += 2) {
    const [i, j] = [edges[e], edges[e + 1]];
    if (isNaN(values[i])) values[i] = values[j]; else if (isNaN(values[j])) values[j] = values[i];
  }
  for (const i of added) values[i] = values[i] || 0;
  return values;
}

// Visual fields with a value for each particle. Residuals are null on pages of older versions.
const kMeasured = {strain: strains, speed: (mesh, x, data) => speeds(mesh, x, data.last, data.dt),
                   residual: (mesh, x, residuals) => residuals};

// Visual fields that need data which a run may lack.
const kNeeds = {patch: (run) => run.meshes.some((mesh) => mesh.patch), colour: (run) => run.meshes.some((mesh) => mesh.colour),
                batch: (run) => run.meshes.some((mesh) => mesh.batch),
                contact: (run) => run.frames.some((frame) => frame.touches),
                force: (run) => run.frames.some((frame) => frame.forces),
                residual: (run) => run.frames.some((frame) => frame.residual)};

// Lines that are drawn beside the bodies.
function marksOf(lines) { return {x: new Float32Array(6 * lines), colours: new Float32Array(6 * lines)}; }

// Lines in the colours of their batches.
function batchMarks(batches, x) {
  const marks = marksOf(batches.numbers.length);
  batches.ends.forEach((i, end) => {
    for (let c = 0; c < 3; ++c) marks.x[3 * end + c] = x[3 * i + c];
    distinct(batches.numbers[end >> 1] + 1).toArray(marks.colours, 3 * end);
  });
  return marks;
}

// The contact normals as lines of this length (m) from the contact points.
function normalMarks(touches, x, length) {
  const marks = marksOf(touches.particles.length), normal = new THREE.Vector3();
  touches.particles.forEach((i, t) => {
    const distance = touches.far * touches.ways[4 * t + 3];
    normal.fromArray(touches.ways, 4 * t).normalize();
    for (let c = 0; c < 3; ++c) {
      const along = normal.getComponent(c);
      marks.x[6 * t + c] = x[3 * i + c] - distance * along;
      marks.x[6 * t + 3 + c] = marks.x[6 * t + c] + length * along;
    }
    kContact.toArray(marks.colours, 6 * t), kContact.toArray(marks.colours, 6 * t + 3);
  });
  return marks;
}

// The forces on pins as lines of `perNewton` metres a newton.
function forceMarks(forces, x, perNewton) {
  const marks = marksOf(forces.particles.length);
  forces.particles.forEach((i, f) => {
    for (let c = 0; c < 3; ++c) {
      marks.x[6 * f + c] = x[3 * i + c];
      marks.x[6 * f + 3 + c] = x[3 * i + c] + perNewton * forces.newtons[3 * f + c];
    }
    kContact.toArray(marks.colours, 6 * f), kContact.toArray(marks.colours, 6 * f + 3);
  });
  return marks;
}
const sizes = (newtons) => Array.from({length: newtons.length / 3}, (_, f) => Math.hypot(...newtons.slice(3 * f, 3 * f + 3)));

// The mean length of the edges at the start, m; 0 without any.
function spacing(mesh, start) {
  const edges = edgesOf(mesh);
  let sum = 0;
  for (let e = 0; e < edges.length; e += 2) sum += distance(start, 3 * edges[e], 3 * edges[e + 1]);
  return sum / Math.max(edges.length / 2, 1);
}

// The legend of a picture's colours, as HTML.
function legendOf(stage) {
  const {look, mesh, most, largest, data} = stage, several = kNumbered[look];
  if (several) return mesh[several] === 1 ? '1 ' + look : (mesh[several] || 'no') + ' ' + several;
  if (look === 'batch') return data ? 'at most ' + data.most + (data.most === 1 ? ' batch' : ' batches') + ' a patch' : 'no batches';
  if (look === 'contact') {
    const n = data ? new Set(data.touches.particles).size : 0;
    return data ? n + (n === 1 ? ' particle touches' : ' particles touch') : 'nothing to touch';
  }
  if (look === 'force') {
    if (!data) return 'no force is known';
    const sum = [0, 1, 2].map((c) => data.newtons.reduce((all, newton, k) => k % 3 === c ? all + newton : all, 0));
    return 'at most ' + number(Math.max(0, ...sizes(data.newtons))) + ' N a pin, all together ' + number(Math.hypot(...sum)) + ' N' +
        (mesh.tooStiff ? ', without ' + mesh.tooStiff + ' constraints that are too stiff' : '');
  }
  if (!kMeasured[look]) return '';
  if (look === 'residual' && !data) return 'no residuals';
  const range = look + ': 0 to ' + number(most) + (look === 'strain' ? '' : look === 'speed' ? ' m/s' : ' m') + ' and more';
  return range + (look === 'residual' ? '; here at most ' + number(largest) + ' m' : '') + '<i></i>';
}
