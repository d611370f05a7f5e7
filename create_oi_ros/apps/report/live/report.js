// Copyright 2026 create_oi_ros contributors
// SPDX-License-Identifier: Apache-2.0
// The report: one time, which slider, charts, track and lists set and show.

import { Charts } from './charts.js';
import { byId } from './dom.js';
import { Map2D } from './map.js';
import { SIGNS } from './map_drawing.js';
import { ReplayTrack } from './replay_track.js';

const STEP = 1, PAGE = 10;  // seconds of the arrow keys, without and with shift
const SECOND = 2;           // a value that comes once a second holds so long, seconds
const FRAME = 0.5;          // and one of the odometry
const DAY = 86400;
const REACH = 14;           // pixels from the track in which a pointer is on it

const data = await unpack(byId('data').textContent);
const curves = Object.fromEntries(Object.entries(data.curves).map(([name, columns]) => [
  name, Object.fromEntries(Object.entries(columns).map(([key, column]) => [key, decode(column)]))]));
const { odom, commands, battery, link } = curves;

async function unpack(text) {
  const raw = Uint8Array.from(atob(text), each => each.charCodeAt(0));
  const stream = new Blob([raw]).stream().pipeThrough(new DecompressionStream('deflate'));
  return new Response(stream).json();
}

// The file has steps of whole numbers; null is a value that is not known.
function decode({ unit, steps }) {
  const values = new Float64Array(steps.length);
  let whole = 0;
  steps.forEach((step, at) => {
    whole += step ?? 0;
    values[at] = step === null ? NaN : whole * unit;
  });
  return values;
}

// The map.

const map = new Map2D(byId('map-canvas'), byId('map-key'), Object.keys(SIGNS));
const track = new ReplayTrack(odom, data.jumps);
map.track = track;
map.scrolls = true;
map.setFollow(false);
byId('no-track').hidden = track.points.length > 0;
byId('map').classList.toggle('empty', !track.points.length);
map.mark(data.spans.flatMap(({ name, spans }) => (SIGNS[name] ? spans.flatMap(([start]) => {
  const pose = poseAt(start);
  return pose ? [[name, pose.x, pose.y]] : [];
}) : [])));

function poseAt(time) { return odom.t.length ? track.poseAt(time) : null; }

// The charts; what was not recorded has none.

const line = (curve, key, name, more = {}) => ({
  name, times: curve.t, values: curve[key], hold: SECOND, ...more });
const commanded = { step: true, hold: data.pause }, measured = { hold: FRAME };
const charts = new Charts(byId('chart-list'), [
  { title: 'Forward, m/s', digits: 2, least: [-0.05, 0.05], lines: [
    line(odom, 'speed', 'measured', measured), line(commands, 'speed', 'commanded', commanded)] },
  { title: 'Turning, rad/s', digits: 2, least: [-0.1, 0.1], lines: [
    line(odom, 'turn', 'measured', measured), line(commands, 'turn', 'commanded', commanded)] },
  { title: 'What holds', rows: data.spans },
  { title: 'Battery, V', digits: 1, least: around(battery.volts), lines: [line(battery, 'volts', '')] },
  { title: 'Current, A', digits: 2, least: [-0.2, 0], lines: [line(battery, 'amperes', '')] },
  { title: 'Charge, %', digits: 0, least: [0, 100], lines: [line(battery, 'charge', '')] },
  { title: 'Frames a second', digits: 0, least: [0, 70], lines: [line(link, 'frames', '')] },
  { title: 'Faults a second', digits: 0, least: [0, 5], lines: [
    line(link, 'damaged', 'damaged frames'), line(link, 'garbage', 'garbage bytes')] },
].map(chart => ({ ...chart, lines: chart.lines?.filter(({ values }) => values.some(Number.isFinite)) }))
  .filter(({ lines, rows }) => (lines || rows).length), name => map.color(name), {
  last: data.seconds, gaps: data.gaps, text: timeText, onTime: seek, onHover: time => show(time ?? now) });

function around(values) {
  const first = values.find(Number.isFinite) ?? 15;
  return [first - 0.25, first + 0.25];
}

// Time.

const slider = byId('slider'), rows = [...document.querySelectorAll('#events tr[data-time]')];
const starts = rows.map(row => Number(row.dataset.time));
const end = odom.t.length ? Math.min(data.seconds, odom.t.at(-1)) : data.seconds;
let now = end, playing = null;
slider.max = data.seconds;

// Seconds since the start as 2:03.4 or 1:02:03.4, or the time of day.
function timeText(seconds) {
  if (byId('utc').getAttribute('aria-pressed') === 'true') {
    return new Date(1000 * (data.began + seconds) + 50).toISOString().slice(11, 21);
  }
  const tenths = Math.round(seconds * 10) / 10;
  const hours = Math.floor(tenths / 3600), minutes = Math.floor(tenths / 60) % 60;
  const rest = (tenths % 60).toFixed(1).padStart(4, '0');
  return hours ? `${hours}:${String(minutes).padStart(2, '0')}:${rest}` : `${minutes}:${rest}`;
}

function seek(time) {
  now = Math.min(data.seconds, Math.max(0, time));
  slider.value = now;
  slider.setAttribute('aria-valuetext', timeText(now));
  charts.setTime(now);
  show(charts.hover ?? now);
}

// Show a moment: the one that was chosen, or the one below the pointer.
function show(time) {
  byId('clock').textContent = timeText(time);
  track.until = time;
  const pose = poseAt(time), degrees = pose && Math.round(pose.yaw * 180 / Math.PI) % 360;
  if (pose) map.move(pose);
  byId('place').textContent = pose
    ? `x ${pose.x.toFixed(2)} m, y ${pose.y.toFixed(2)} m, heading ${degrees}°` : '';
  map.set('bump', bumped(time));
  const current = starts.findLastIndex(start => start <= time + 1e-3);
  rows.forEach((row, at) => row.classList.toggle('current', at === current));
}

function bumped(time) {
  const bumps = data.spans.find(({ name }) => name === 'bumper')?.spans ?? [];
  const text = bumps.find(([start, until]) => start <= time && time < until)?.[2] || '';
  return { left: text.includes('left'), right: text.includes('right') };
}

function play(on) {
  playing = on ? performance.now() : null;
  byId('play').textContent = on ? '❚❚' : '▶';
  byId('play').setAttribute('aria-label', on ? 'Pause' : 'Play');
  if (on && now >= end) seek(0);
  if (on) requestAnimationFrame(advance);
}

function advance(time) {
  if (playing === null) return;
  seek(now + Math.max(0, time - playing) / 1000 * Number(byId('pace').value));
  playing = time;
  if (now >= data.seconds) play(false);
  else requestAnimationFrame(advance);
}

slider.addEventListener('input', () => { play(false); seek(Number(slider.value)); });
byId('play').addEventListener('click', () => play(playing === null));
addEventListener('keydown', event => {
  if (event.target.closest('input, select, button, summary') || event.ctrlKey || event.metaKey) return;
  const step = event.shiftKey ? PAGE : STEP;
  const act = {
    ArrowLeft: () => seek(now - step), ArrowRight: () => seek(now + step), Home: () => seek(0),
    End: () => seek(data.seconds), '+': () => charts.zoom(0.7), '-': () => charts.zoom(1 / 0.7),
    ' ': () => play(playing === null), f: () => map.setFollow(!map.follow),
  }[event.key];
  if (!act) return;
  event.preventDefault();
  act();
});
const jumps = [...document.querySelectorAll('tr[data-time]')].map(row => {
  const button = row.querySelector('button'), time = Number(row.dataset.time);
  button.addEventListener('click', () => { play(false); seek(time); });
  return { button, time };
});
const showTimes = () => {
  for (const { button, time } of jumps) button.textContent = timeText(time);
};
showTimes();
byId('utc').addEventListener('click', () => {
  const utc = byId('utc').getAttribute('aria-pressed') === 'false';
  byId('utc').setAttribute('aria-pressed', String(utc));
  charts.zero = utc ? -(data.began % DAY) : 0;
  showTimes();
  charts.redraw();
  show(now);
});

// The track below a pointer.

const canvas = byId('map-canvas');
const near = (x, y) => track.timeNear(x, y, REACH / map.scale);
canvas.addEventListener('pointermove', event => {
  if (event.pointerType === 'mouse' && !event.buttons) charts.peek(near(...map.placeOf(event)));
});
canvas.addEventListener('pointerleave', () => charts.peek(null));
map.onTap = (x, y) => {
  const time = near(x, y);
  if (time !== null) seek(time);
};

// Buttons.

byId('time-in').addEventListener('click', () => charts.zoom(0.5));
byId('time-out').addEventListener('click', () => charts.zoom(2));
byId('time-all').addEventListener('click', () => charts.show(0, data.seconds));
byId('trouble').textContent = data.damage;
byId('trouble').hidden = !data.damage;

map.showAll();
seek(now);
