// The page: one run, or two in step, with time, looks, numbers and graphs.
'use strict';

const $ = (id) => document.getElementById(id);
const kSpeeds = [0.05, 0.1, 0.25, 0.5, 1, 2], kLooks = ['shaded', 'wire', 'particles', 'strain', 'speed'];
const kGraphs = [
  {title: 'ms a step', keys: [['step_ms', '#444', 'step']]},
  {title: 'energy (J)', keys: [['kinetic', '#d62728', 'kinetic'], ['elastic', '#2ca02c', 'elastic'],
                               ['potential', '#1f77b4', 'potential']]},
  {title: 'strain of constraints', keys: [['strain_max', '#d62728', 'largest'], ['strain_rms', '#1f77b4', 'RMS']]},
  {title: 'momentum (kg m/s), angular momentum (kg m²/s)', keys: [['momentum', '#1f77b4', 'linear'],
                                                                  ['angular_momentum', '#9467bd', 'angular']]},
  {title: 'largest speed (m/s)', keys: [['speed_max', '#444', 'speed']]},
  {title: 'penetration (m)', keys: [['penetration_max', '#444', 'penetration']]},
  {title: 'contacts, crossings', keys: [['contacts', '#1f77b4', 'contacts'], ['crossings', '#d62728', 'crossings']]},
];

// What tests and the console can ask for.
const malha = window.malha = {time: 0, playing: false, speed: 1, look: 'shaded', ready: false, views: []};

function element(tag, parent, text, name) {
  const made = document.createElement(tag);
  if (text !== undefined) made.textContent = text;
  if (name) made.className = name;
  parent.appendChild(made);
  return made;
}
function number(value) {
  if (value === 0) return '0';
  const size = Math.abs(value);
  return size < 1e-3 || size >= 1e5 ? value.toExponential(2) : String(Number(value.toPrecision(3)));
}
const counted = (n, what) => n + ' ' + what + (n === 1 ? '' : 's');
function fail(text) {
  element('div', $('views'), text, 'error');
  malha.error = text;
}
const titleOf = (run) => run.report.scene || 'run';

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
  const scales = {strain: usual('strain_max'), speed: usual('speed_max')};
  for (const view of malha.views) view.stage.scales = scales, await view.stage.prepare();
  $('time').min = malha.start, $('time').max = malha.end;
  fillPanel();
  showAll(true);
  listen();
  await seek(malha.start);
  malha.ready = true;
}

// The largest of all but a tenth of all frames: one scale for both runs and all times.
function usual(key) {
  const all = malha.views.flatMap((view) => view.frames.all.map((frame) => frame.measures[key])).sort((a, b) => a - b);
  return all[Math.floor(0.9 * (all.length - 1))];
}

// Solver and settings, which two runs of one scene differ in.
function nameOf(run) {
  const solver = run.report.input.scene.solver || {};
  return [titleOf(run), solver.type, number(solver.dt * 1000) + ' ms', counted(solver.substeps, 'substep'),
          counted(solver.iterations, 'iteration')].join(', ');
}

// Both cameras are one.
function follow(view) {
  for (const other of malha.views) if (other !== view) other.controls.target.copy(view.controls.target);
}

function showAll(first) {
  const box = new THREE.Box3();
  for (const view of malha.views) box.union(view.stage.box());
  const sphere = box.getBoundingSphere(new THREE.Sphere()), camera = malha.camera, given = malha.views[0].run.camera;
  const r = sphere.radius || 1;
  camera.near = r / 500, camera.far = 200 * r;
  if (first && given) {
    camera.fov = given.fov_degrees;
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

// Shows every run at its last frame that is not after this time.
let latest = 0;
async function seek(time) {
  malha.time = Math.min(Math.max(time, malha.start), malha.end);
  const turn = ++latest;
  await Promise.all(malha.views.map((view) => view.stage.show(view.frames.at(malha.time))));
  if (turn !== latest) return;
  describe();
  redraw();
}

let drawing = false;
function redraw() {
  if (drawing) return;
  drawing = true;
  requestAnimationFrame(() => {
    drawing = false;
    for (const view of malha.views) {
      malha.camera.aspect = view.canvas.clientWidth / Math.max(view.canvas.clientHeight, 1);
      malha.camera.updateProjectionMatrix();
      if (view.stage.shown >= 0) view.stage.render(malha.camera);
      drawScale(view);
    }
    malha.drawn = (malha.drawn || 0) + 1;
  });
}

// A length in metres, as it is at the point that the camera looks at.
function drawScale(view) {
  const camera = malha.camera, distance = camera.position.distanceTo(view.controls.target);
  const pixel = 2 * distance * Math.tan(camera.fov * Math.PI / 360) / Math.max(view.canvas.clientHeight, 1);
  const ten = Math.pow(10, Math.floor(Math.log10(150 * pixel))), metres = [5, 2, 1].map((k) => k * ten).find((m) => m <= 150 * pixel);
  view.scale.innerHTML = number(metres) + ' m<i style="width:' + metres / pixel + 'px"></i>';
}

// Of graphs: where a time lies.
const graphX = (time) => 56 + 234 * (time - malha.start) / (malha.end - malha.start || 1);

function describe() {
  const [one, other] = malha.views, shown = one.frames.all[one.stage.shown];
  $('time').value = malha.time;
  $('clock').textContent = malha.time.toFixed(3) + ' s, step ' + shown.step;
  for (const view of malha.views) {
    const coloured = malha.look === 'strain' || malha.look === 'speed';
    view.legend.innerHTML = coloured ? malha.look + ': 0 to ' + number(view.stage.most) + (malha.look === 'speed' ? ' m/s' : '') + ' and more<i></i>' : '';
    const measures = view.frames.all[view.stage.shown].measures;
    for (const [key, cell] of Object.entries(view.cells)) cell.textContent = number(measures[key]);
  }
  if (other && malha.apart) malha.apart.textContent = distanceApart(one, other);
  for (const cursor of document.querySelectorAll('.cursor')) {
    cursor.setAttribute('x1', graphX(malha.time)), cursor.setAttribute('x2', graphX(malha.time));
  }
}

function distanceApart(one, other) {
  const a = one.stage.x.array, b = other.stage.x.array;
  if (a.length !== b.length) return 'not the same particles';
  if (Math.abs(one.frames.all[one.stage.shown].time - other.frames.all[other.stage.shown].time) > 1e-9) return 'no frames of the same time';
  let most = 0, sum = 0;
  for (let i = 0; i < a.length; i += 3) {
    const far = Math.hypot(a[i] - b[i], a[i + 1] - b[i + 1], a[i + 2] - b[i + 2]);
    most = Math.max(most, far), sum += far * far;
  }
  return number(most) + ' m at most, ' + number(Math.sqrt(sum / Math.max(a.length / 3, 1))) + ' m RMS';
}

function fillPanel() {
  const panel = $('panel');
  if (malha.views.length > 1) {
    element('h2', panel, 'Distance between the two');
    malha.apart = element('div', panel, '');
    malha.apart.id = 'apart';
  }
  for (const view of malha.views) {
    const run = view.run, report = run.report;
    element('h1', panel, malha.views.length > 1 ? nameOf(run) : titleOf(run));
    for (const warning of run.warnings) element('div', panel, warning, 'warning');
    const count = run.meshes[0].count, frames = run.frames.length;
    element('div', panel, count.toLocaleString('en') + (count === 1 ? ' particle; ' : ' particles; ') + frames + (frames === 1 ? ' frame' : ' frames, one ' + (run.every === 1 ? 'a step' : 'every ' + run.every + ' steps')) +
        '; places are rounded by at most ' + number(run.rounding * 1000) + ' mm. malha ' + run.malha + ', ' + report.status + '.');
    for (const graph of kGraphs) drawGraph(panel, view, graph);
    element('h2', panel, 'Now');
    const table = element('table', panel);
    view.cells = {};
    for (const key of Object.keys(run.frames[0].measures)) {
      const row = element('tr', table);
      element('td', row, key.replace('_', ' ')), view.cells[key] = element('td', row, '');
    }
    for (const [title, what] of [['Report', {...report, input: undefined}], ['Scene', report.input.scene]]) {
      const details = element('details', panel);
      element('summary', details, title);
      details.addEventListener('toggle', () => {
        if (!details.querySelector('pre')) element('pre', details, JSON.stringify(what, null, 1));
      });
    }
  }
}

function drawGraph(panel, view, graph) {
  const frames = view.run.frames, value = (frame, key) => key === 'step_ms' ? frame.step_ms : frame.measures[key];
  const kept = graph.keys.filter(([key]) => frames.some((frame) => value(frame, key) !== 0));
  if (kept.length === 0 || frames.length < 2) return;
  const all = kept.flatMap(([key]) => frames.map((frame) => value(frame, key)));
  let low = 0, high = 0;
  for (const one of all) low = Math.min(low, one), high = Math.max(high, one);
  const y = (v) => 80 - 70 * (v - low) / (high - low || 1);
  element('h2', panel, graph.title);
  const lines = kept.map(([key, colour, label], k) => {
    const points = frames.filter((frame) => key !== 'step_ms' || frame.step_ms > 0).map((frame) => graphX(frame.time).toFixed(1) + ',' + y(value(frame, key)).toFixed(1));
    return '<polyline fill="none" stroke="' + colour + '" points="' + points.join(' ') + '"/>' +
        (kept.length > 1 ? '<text x="' + (62 + 70 * k) + '" y="9" style="fill:' + colour + '">' + label + '</text>' : '');
  });
  const svg = element('div', panel);
  svg.innerHTML = '<svg viewBox="0 0 300 90" preserveAspectRatio="none"><line x1="56" x2="290" y1="' + y(0) + '" y2="' + y(0) +
      '" stroke="#ccc"/>' + lines.join('') + '<line class="cursor" x1="56" x2="56" y1="5" y2="85" stroke="#888"/>' +
      '<text x="53" y="14" text-anchor="end">' + number(high) + '</text><text x="53" y="82" text-anchor="end">' + number(low) + '</text></svg>';
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
    const act = /^[1-5]$/.test(event.key) ? () => setLook(kLooks[event.key - 1]) : keys[event.key];
    if (!act) return;
    event.preventDefault();
    act();
  });
}

// Where a particle is on the screen, in pixels of the page.
malha.seek = seek, malha.setLook = setLook;
malha.pixelOf = (v, i) => {
  const view = malha.views[v], x = view.stage.x.array, at = view.canvas.getBoundingClientRect();
  malha.camera.aspect = at.width / at.height, malha.camera.updateProjectionMatrix();
  const p = new THREE.Vector3(x[3 * i], x[3 * i + 1], x[3 * i + 2]).project(malha.camera);
  return [at.left + (p.x + 1) / 2 * at.width, at.top + (1 - p.y) / 2 * at.height];
};

begin().catch((error) => fail(String(error)));
