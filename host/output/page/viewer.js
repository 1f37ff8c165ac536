// SPDX-License-Identifier: Apache-2.0
// The page's controls: playback of one run, or of two side by side, camera, keys and visual fields.
'use strict';

const kSpeeds = [0.05, 0.1, 0.25, 0.5, 1, 2], kKeys = '1234567890';  // of visual fields
const kLooks = ['shaded', 'wire', 'particles', 'strain', 'speed', 'patch', 'colour', 'batch', 'contact', 'residual', 'force'];

// The interface for tests and the console.
const malha = window.malha = {time: 0, playing: false, speed: 1, look: 'shaded', ready: false, views: []};

function fail(text) {
  element('div', $('views'), text, 'error');
  malha.error = text;
}

async function begin() {
  if (typeof DecompressionStream === 'undefined') return fail('This page needs a browser of 2023 or later.');
  const runs = [...document.querySelectorAll('script.run')].map((script) => JSON.parse(script.textContent));
  malha.camera = new THREE.PerspectiveCamera(40, 1, 0.01, 100);
  for (const run of runs) {
    const holder = element('div', $('views'), undefined, 'view'), canvas = element('canvas', holder);
    canvas.tabIndex = 0;
    const view = {run, canvas, frames: new Frames(run)};
    try {
      view.stage = new Stage(run, view.frames, canvas);
    } catch (error) {
      holder.remove();
      return fail('This browser has no WebGL: ' + error.message);
    }
    element('div', holder, runs.length > 1 ? nameOf(run) : '', 'name');
    view.scale = element('div', holder, undefined, 'scale'), view.legend = element('div', holder, undefined, 'legend');
    view.controls = new THREE.OrbitControls(malha.camera, canvas);
    view.controls.enableKeys = false, view.controls.screenSpacePanning = true;
    view.controls.addEventListener('change', () => { follow(view); redraw(); });
    malha.views.push(view);
  }
  document.title = malha.views.map((view) => titleOf(view.run)).join(' and ') + ' - malha';
  malha.start = Math.min(...malha.views.map((view) => view.frames.start));
  malha.end = Math.max(...malha.views.map((view) => view.frames.end));
  chooseOrigin(malha.views[0].stage.box());
  const scales = {strain: commonScale((frame) => frame.measures.strain_max), speed: commonScale((frame) => frame.measures.speed_max),
                  residual: commonScale((frame) => frame.residual ? frame.residual.most : 0)};
  // One scale of forces for both runs and all times.
  const newtons = commonScale((frame) => frame.forces ? Math.hypot(...frame.forces.newtons.low.map(
      (low, k) => Math.max(Math.abs(low), Math.abs(low + frame.forces.newtons.side[k])))) : 0);
  const size = malha.views[0].stage.box().getSize(new THREE.Vector3()).length();
  scales.metresPerNewton = newtons > 0 ? size / 6 / newtons : 0;
  for (const view of malha.views) view.stage.scales = scales, await view.stage.prepare();
  $('time').min = malha.start, $('time').max = malha.end;
  fillPanel();
  malha.looks = kLooks.filter((look) => !kNeeds[look] || runs.some(kNeeds[look]));
  for (const option of [...$('look').options]) if (!malha.looks.includes(option.value)) option.remove();
  showAll(true);
  listen();
  await seek(malha.start);
  malha.ready = true;
  if (malha.views.length > 1) play();
}

// The views share one camera; this copies the orbit target to the others.
function follow(view) {
  for (const other of malha.views) if (other !== view) other.controls.target.copy(view.controls.target);
}

// The camera of the scene's pictures with their aspect ratio; null for two runs with different ones.
function cameraOfPictures() {
  const of = (run) => JSON.stringify(run.camera || null), [one, ...others] = malha.views.map((view) => view.run);
  if (!one.camera || others.some((run) => of(run) !== of(one))) return null;
  const [width, height] = one.report.input.scene.outputs.pictures.size;
  return {...one.camera, aspect: width / height};
}

// Sets the field of view; a view that is narrower than the picture shows the picture's whole width.
function aim(view) {
  const camera = malha.camera;
  camera.aspect = view.canvas.clientWidth / Math.max(view.canvas.clientHeight, 1);
  const wider = malha.lens.aspect ? Math.max(1, malha.lens.aspect / camera.aspect) : 1;
  camera.fov = 360 / Math.PI * Math.atan(Math.tan(malha.lens.fov * Math.PI / 360) * wider);
  camera.updateProjectionMatrix();
}

function showAll(first) {
  const box = new THREE.Box3();
  for (const view of malha.views) box.union(view.stage.box());
  const sphere = box.getBoundingSphere(new THREE.Sphere()), camera = malha.camera, given = first && cameraOfPictures();
  const r = sphere.radius || 1;
  camera.near = r / 500, camera.far = 200 * r;
  malha.lens = {fov: given ? given.fov_degrees : malha.lens ? malha.lens.fov : camera.fov, aspect: given ? given.aspect : 0};
  for (const view of malha.views) aim(view);
  if (given) {
    const from = (at) => at.map((value, k) => value - origin[k]);
    camera.position.set(...from(given.eye)), malha.views[0].controls.target.set(...from(given.target));
  } else {
    const tan = Math.tan(camera.fov * Math.PI / 360), aspect = malha.views[0].canvas.clientWidth / malha.views[0].canvas.clientHeight;
    const distance = r / Math.sin(Math.atan(tan * Math.min(1, aspect || 1)));
    camera.position.copy(sphere.center).add(new THREE.Vector3(0.45, 0.45, 0.8).normalize().multiplyScalar(distance));
    malha.views[0].controls.target.copy(sphere.center);
  }
  follow(malha.views[0]);
  for (const view of malha.views) view.controls.update();
  redraw();
}

// Shows each run's last frame that is not after this time.
let latest = 0;
async function seek(time) {
  malha.time = Math.min(Math.max(time, malha.start), malha.end);
  const turn = ++latest;
  await Promise.all(malha.views.map((view) => view.stage.show(view.frames.at(malha.time))));
  const apart = malha.views.length > 1 ? await distanceApart(...malha.views) : '';
  if (turn !== latest) return;
  describe(apart);
  redraw();
}

let drawing = false;
function redraw() {
  if (drawing) return;
  drawing = true;
  requestAnimationFrame(() => {
    drawing = false;
    for (const view of malha.views) {
      aim(view);
      if (view.stage.shown >= 0) view.stage.render(malha.camera);
      drawScale(view);
    }
    malha.drawn = (malha.drawn || 0) + 1;
  });
}

// Draws the scale bar, in metres at the distance of the camera's target.
function drawScale(view) {
  const camera = malha.camera, distance = camera.position.distanceTo(view.controls.target);
  const pixel = 2 * distance * Math.tan(camera.fov * Math.PI / 360) / Math.max(view.canvas.clientHeight, 1);
  const ten = Math.pow(10, Math.floor(Math.log10(150 * pixel))), metres = [5, 2, 1].map((k) => k * ten).find((m) => m <= 150 * pixel);
  view.scale.innerHTML = number(metres) + ' m<i style="width:' + metres / pixel + 'px"></i>';
}

function describe(apart) {
  const one = malha.views[0], shown = one.frames.all[one.stage.shown];
  $('time').value = malha.time;
  $('clock').textContent = malha.time.toFixed(3) + ' s, step ' + shown.step;
  for (const view of malha.views) {
    view.legend.innerHTML = legendOf(view.stage);
    const measures = view.frames.all[view.stage.shown].measures;
    for (const [key, cell] of Object.entries(view.cells)) cell.textContent = number(measures[key]);
  }
  if (malha.apart) malha.apart.textContent = apart;
  for (const cursor of document.querySelectorAll('.cursor')) {
    cursor.setAttribute('x1', graphX(malha.time)), cursor.setAttribute('x2', graphX(malha.time));
  }
}

function setLook(look) {
  malha.look = look, $('look').value = look;
  for (const view of malha.views) view.stage.look = look;
  return seek(malha.time);
}
function setSpeed(speed) {
  malha.speed = speed, $('speed').value = String(speed);
}
function step(by) {
  pause();
  const times = malha.views.flatMap((view) => view.frames.all.map((frame) => frame.time)).sort((a, b) => a - b);
  const next = by > 0 ? times.find((time) => time > malha.time + 1e-9) : times.reverse().find((time) => time < malha.time - 1e-9);
  return seek(next === undefined ? malha.time : next);
}
function pause() { malha.playing = false, $('play').textContent = 'play'; }
function play() {
  if (malha.playing) return pause();
  if (malha.time >= malha.end) malha.time = malha.start;
  malha.playing = true, $('play').textContent = 'pause';
  let before = performance.now();
  const go = async (now) => {
    if (!malha.playing) return;
    const next = malha.time + malha.speed * Math.min((now - before) / 1000, 0.25);
    before = now;
    if (next >= malha.end) pause();
    await seek(next);
    if (malha.playing) requestAnimationFrame(go);
  };
  requestAnimationFrame(go);
}

function listen() {
  $('play').addEventListener('click', play);
  $('time').addEventListener('input', () => { pause(); seek(Number($('time').value)); });
  $('speed').addEventListener('change', () => setSpeed(Number($('speed').value)));
  $('look').addEventListener('change', () => setLook($('look').value));
  $('frame').addEventListener('click', () => showAll(false));
  $('help').addEventListener('click', () => $('keys').showModal());
  window.addEventListener('resize', redraw);
  window.addEventListener('keydown', (event) => {
    if (event.ctrlKey || event.altKey || event.metaKey || $('keys').open || ['SELECT', 'SUMMARY'].includes(event.target.tagName)) return;
    const faster = (by) => setSpeed(kSpeeds[Math.min(Math.max(kSpeeds.indexOf(malha.speed) + by, 0), kSpeeds.length - 1)]);
    const keys = {' ': play, ArrowLeft: () => step(-1), ArrowRight: () => step(1), Home: () => seek(malha.start),
                  End: () => seek(malha.end), '+': () => faster(1), '-': () => faster(-1), f: () => showAll(false),
                  F: () => showAll(false), '?': () => $('keys').showModal()};
    const look = kLooks[kKeys.indexOf(event.key)], act = malha.looks.includes(look) ? () => setLook(look) : keys[event.key];
    if (!act) return;
    event.preventDefault();
    act();
  });
}

// Position of a particle in pixels of the page.
malha.seek = seek, malha.setLook = setLook, malha.pause = pause;
malha.pixelOf = (v, i) => {
  const view = malha.views[v], x = view.stage.x.array, at = view.canvas.getBoundingClientRect();
  aim(view);
  const p = new THREE.Vector3(x[3 * i], x[3 * i + 1], x[3 * i + 2]).project(malha.camera);
  return [at.left + (p.x + 1) / 2 * at.width, at.top + (1 - p.y) / 2 * at.height];
};

begin().catch((error) => fail(String(error)));
