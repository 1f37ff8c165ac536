// SPDX-License-Identifier: Apache-2.0
// The panel beside the pictures: name, measures, graphs, report and scene of each run.
'use strict';

const $ = (id) => document.getElementById(id);
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
const kUnits = {kinetic: 'J', potential: 'J', elastic: 'J', speed_max: 'm/s', momentum: 'kg m/s',
                angular_momentum: 'kg m²/s', penetration_max: 'm'};
const kMostNames = 24;  // of bodies

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
const titleOf = (run) => run.report.scene || 'run';

// The value below which nine of ten frames of all runs stay: one scale for both runs and all times.
function commonScale(valueOf) {
  const all = malha.views.flatMap((view) => view.frames.all.map(valueOf)).sort((a, b) => a - b);
  return all[Math.floor(0.9 * (all.length - 1))];
}

// Folder, solver and settings, in which two runs of one scene may differ.
function nameOf(run) {
  const solver = run.report.input.scene.solver || {}, folder = run.folder === undefined ? titleOf(run) : run.folder;
  return [folder, solver.type, number(solver.dt * 1000) + ' ms', counted(solver.substeps, 'substep'),
          counted(solver.iterations, 'iteration')].join(', ');
}

// The x coordinate of a time in the graphs.
const graphX = (time) => 56 + 234 * (time - malha.start) / (malha.end - malha.start || 1);

// Distance of two runs at the present time, interpolated linearly between frames.
async function distanceApart(one, other) {
  const time = malha.time, early = (view) => time < view.frames.start - 1e-9 || time > view.frames.end + 1e-9;
  if (early(one) || early(other)) return 'only one of the runs has frames at this time';
  const [a, b] = await Promise.all([one.frames.positionsAt(time), other.frames.positionsAt(time)]);
  if (!a || !b) return 'unknown: a body tears between two frames';
  if (a.length !== b.length) return 'not the same particles';
  let most = 0, sum = 0;
  for (let i = 0; i < a.length; i += 3) {
    const far = Math.hypot(a[i] - b[i], a[i + 1] - b[i + 1], a[i + 2] - b[i + 2]);
    most = Math.max(most, far), sum += far * far;
  }
  return number(most) + ' m at most, ' + number(Math.sqrt(sum / Math.max(a.length / 3, 1))) + ' m RMS';
}

// Adds the legend of the bodies' colours.
function addBodies(panel, bodies) {
  if (bodies.length < 2) return;
  const names = element('div', panel, undefined, 'bodies');
  for (const body of bodies.slice(0, kMostNames)) {
    const one = element('span', names, body.name), swatch = document.createElement('i');
    swatch.style.background = 'rgb(' + body.colour.map((part) => Math.round(255 * part)) + ')';
    one.prepend(swatch);
  }
  if (bodies.length > kMostNames) element('span', names, 'and ' + (bodies.length - kMostNames) + ' more');
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
        '; positions are rounded by at most ' + number(run.rounding * 1000) + ' mm. malha ' + run.malha + ', ' + report.status + '.');
    const begins = run.frames[0].step;
    if (begins > 0) element('div', panel, 'This run was resumed at step ' + begins + ': earlier frames are not in this page.', 'resumed');
    addBodies(panel, run.bodies);
    for (const graph of kGraphs) drawGraph(panel, view, graph);
    element('h2', panel, 'Now');
    const table = element('table', panel);
    view.cells = {};
    for (const key of Object.keys(run.frames[0].measures)) {
      const row = element('tr', table);
      element('td', row, key.replace('_', ' ')), view.cells[key] = element('td', row, ''), element('td', row, kUnits[key] || '');
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
  svg.innerHTML = '<svg viewBox="0 0 300 102" preserveAspectRatio="none"><line x1="56" x2="290" y1="' + y(0) + '" y2="' + y(0) +
      '" stroke="#ccc"/>' + lines.join('') + '<line class="cursor" x1="56" x2="56" y1="5" y2="85" stroke="#888"/>' +
      '<text x="53" y="14" text-anchor="end">' + number(high) + '</text><text x="53" y="82" text-anchor="end">' + number(low) + '</text>' +
      '<text x="56" y="97">' + number(malha.start) + ' s</text>' +
      '<text x="290" y="97" text-anchor="end">' + number(malha.end) + ' s</text></svg>';
}
