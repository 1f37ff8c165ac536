// SPDX-License-Identifier: Apache-2.0
// Decoding of a run's data: the counterpart of host/output/page_pack.cpp.
'use strict';

async function inflated(text) {
  const letters = atob(text), bytes = new Uint8Array(letters.length);
  for (let i = 0; i < bytes.length; ++i) bytes[i] = letters.charCodeAt(i);
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream('deflate'));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

// Decodes `count` numbers of `bytes` bytes each, stored as differences to those `stride` before.
const kWords = {1: Uint8Array, 2: Uint16Array, 4: Uint32Array};
async function unpacked(text, count, stride, bytes) {
  const planes = await inflated(text), numbers = new kWords[bytes](count);
  if (planes.length !== count * bytes) throw new Error('found ' + planes.length + ' bytes of ' + count * bytes);
  for (let i = 0; i < count; ++i) {
    let step = 0;
    for (let b = bytes - 1; b >= 0; --b) step = step * 256 + planes[b * count + i];
    numbers[i] = step + (i < stride ? 0 : numbers[i - stride]);
  }
  return numbers;
}

// Origin of the rendered coordinates (m), because single precision is coarse far from 0.
const origin = [0, 0, 0];
function chooseOrigin(box) {
  const size = box.getSize(new THREE.Vector3()).length(), centre = box.getCenter(new THREE.Vector3());
  if (centre.length() > 100 * size) centre.toArray(origin);
}

// Decodes positions relative to the origin (m), as x y z of each point.
async function positions(points, count, from = origin) {
  const positions = new Float32Array(3 * count);
  if (count === 0) return positions;
  const steps = await unpacked(points.data, 3 * count, 3, 2);
  for (let i = 0; i < positions.length; ++i) positions[i] = points.low[i % 3] - from[i % 3] + points.side[i % 3] / 65535 * steps[i];
  return positions;
}

// Visual fields that number particles, and the names of their counts in a page.
const kNumbered = {patch: 'patches', colour: 'colours'};

// Decodes a mesh for WebGL and the visual fields.
async function meshOf(packed) {
  const faces = await unpacked(packed.faces, 4 * packed.face_count, 4, 4);
  const lines = await unpacked(packed.lines, 2 * packed.line_count, 2, 4);
  const triangles = trianglesOf(faces);
  const all = {count: packed.count, faces, lines, triangles, bodyBegin: packed.body_begin, tooStiff: packed.too_stiff || 0, edges: null};
  for (const [look, several] of Object.entries(kNumbered))
    if (packed[look]) all[look] = await unpacked(packed[look], packed.count, 1, 4), all[several] = packed[several];
  return all;
}

// A quad is two triangles; a triangle repeats its third corner.
function trianglesOf(faces) {
  const all = new Uint32Array(faces.length / 4 * 6);
  let n = 0;
  for (let f = 0; f < faces.length; f += 4) {
    const a = faces[f], b = faces[f + 1], c = faces[f + 2], d = faces[f + 3];
    all[n++] = a, all[n++] = b, all[n++] = c;
    if (d !== c) all[n++] = a, all[n++] = c, all[n++] = d;
  }
  return all.slice(0, n);
}

// The edges of faces, and lines, without duplicates.
function edgesOf(mesh) {
  if (mesh.edges) return mesh.edges;
  const n = mesh.count, keys = new Float64Array(mesh.faces.length + mesh.lines.length / 2);
  let k = 0;
  const add = (a, b) => { if (a !== b) keys[k++] = Math.min(a, b) * n + Math.max(a, b); };
  for (let f = 0; f < mesh.faces.length; f += 4) {
    const [a, b, c, d] = mesh.faces.subarray(f, f + 4);
    add(a, b), add(b, c), add(c, d), add(d, a);
  }
  for (let l = 0; l < mesh.lines.length; l += 2) add(mesh.lines[l], mesh.lines[l + 1]);
  const sorted = keys.subarray(0, k).sort(), edges = new Uint32Array(2 * k);
  let e = 0;
  for (let i = 0; i < k; ++i) {
    if (i > 0 && sorted[i] === sorted[i - 1]) continue;
    const low = Math.floor(sorted[i] / n);
    edges[e++] = low, edges[e++] = sorted[i] - low * n;
  }
  return mesh.edges = edges.slice(0, e);
}

// The frames of a run, decoded on demand, with a cache of those used last.
class Frames {
  constructor(run) {
    this.run = run, this.all = run.frames, this.read = new Map(), this.meshes = new Map(), this.bytes = 0;
  }
  get start() { return this.all[0].time; }
  get end() { return this.all[this.all.length - 1].time; }
  // Index of the last frame that is not after this time.
  at(time) {
    let low = 0, high = this.all.length - 1;
    while (low < high) {
      const middle = (low + high + 1) >> 1;
      if (this.all[middle].time <= time + 1e-9) low = middle; else high = middle - 1;
    }
    return low;
  }
  // Index of the frame for the finite difference of speeds: the one before, or the next if only that one has the same
  // mesh.
  beside(k) {
    const alike = (j) => this.all[j] !== undefined && this.all[j].mesh === this.all[k].mesh;
    return k > 0 && (alike(k - 1) || !alike(k + 1)) ? k - 1 : Math.min(k + 1, this.all.length - 1);
  }
  mesh(k) {
    const m = this.all[k].mesh;
    if (!this.meshes.has(m)) this.meshes.set(m, meshOf(this.run.meshes[m]));
    return this.meshes.get(m);
  }
  // The following are null for runs without such data, and for pages of older versions. Lines with the indices of both
  // ends and of the batch, and the largest number of batches in a patch.
  async batches(k) {
    const {batch} = this.run.meshes[this.all[k].mesh], mesh = await this.mesh(k);
    if (!batch || mesh.batches) return mesh.batches || null;
    const [ends, numbers] = await Promise.all(
        [unpacked(batch.ends, 2 * batch.count, 2, 4), unpacked(batch.numbers, batch.count, batch.count, 4)]);
    for (let e = 0; e < ends.length; e += 2) ends[e + 1] += ends[e];
    return mesh.batches = {ends, numbers, most: batch.most};
  }
  // Residual of each particle, m.
  async residuals(k) {
    const {residual, mesh} = this.all[k], count = this.run.meshes[mesh].count;
    return residual ? Float32Array.from(await unpacked(residual.data, count, count, 1), (step) => residual.most / 255 * step) : null;
  }
  // Contact points: the particles, and four numbers for each: the normal, and the distance over the largest one.
  async touches(k) {
    const {touches} = this.all[k];
    if (!touches) return null;
    const [particles, ways] = await Promise.all(
        [unpacked(touches.particles, touches.count, 1, 4), unpacked(touches.ways, 4 * touches.count, 4, 1)]);
    return {particles, ways: Float32Array.from(ways, (step) => step / 127 - 1), far: touches.far};
  }
  // Forces on pins: the particles, and x y z of each force in N.
  async forces(k) {
    const {forces} = this.all[k];
    if (!forces) return null;
    const [particles, newtons] = await Promise.all(
        [unpacked(forces.particles, forces.count, 1, 4), positions(forces.newtons, forces.count, [0, 0, 0])]);
    return {particles, newtons};
  }
  // Points of the d-th object that deforms.
  deformed(k, d, count) { return positions(this.all[k].deformed[d], count); }
  positions(k) {
    const most = 256e6;  // bytes
    if (this.read.has(k)) {
      const known = this.read.get(k);
      this.read.delete(k), this.read.set(k, known);
      return known;
    }
    const frame = this.all[k], count = this.run.meshes[frame.mesh].count, promise = positions(frame.points, count);
    this.read.set(k, promise), this.bytes += 12 * count;
    for (const old of this.read.keys()) {
      if (this.bytes <= most || old === k) break;
      this.bytes -= 12 * this.run.meshes[this.all[old].mesh].count, this.read.delete(old);
    }
    return promise;
  }
  // Linear interpolation between frames; null if a tear lies between them.
  async positionsAt(time) {
    const k = this.at(time), one = this.all[k], next = this.all[k + 1], x = await this.positions(k);
    const part = next ? (time - one.time) / (next.time - one.time) : 0;
    if (part < 1e-6) return x;
    if (next.mesh !== one.mesh) return null;
    const y = await this.positions(k + 1);
    return x.map((at, i) => at + part * (y[i] - at));
  }
}

// Maps the positions of one mesh's particles to the numbering of another; NaN for particles that it lacks. Tears append
// particles to their bodies.
function renumbered(x, from, to) {
  if (from === to) return x;
  const all = new Float32Array(3 * to.count).fill(NaN);
  for (let b = 0; b + 1 < to.bodyBegin.length; ++b) {
    const begin = from.bodyBegin[b], end = Math.min(from.bodyBegin[b + 1], begin + to.bodyBegin[b + 1] - to.bodyBegin[b]);
    all.set(x.subarray(3 * begin, 3 * end), 3 * to.bodyBegin[b]);
  }
  return all;
}
