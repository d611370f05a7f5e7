// Copyright 2026 create_oi_ros contributors
// SPDX-License-Identifier: Apache-2.0
// The report: a time slider that drives the map, charts below one cursor, lists that jump.

import { decode, unpack } from './curves.js';
import { Map2D } from './map.js';
import { ReplayTrack } from './replay_track.js';
import { clock, TimeCharts } from './time_charts.js';

const byId = id => document.getElementById(id);
const SIGNS = { bumper: 'bump', cliff: 'cliff', 'wheel drop': 'drop' };
const STEP = 1, PAGE = 10;  // seconds of the arrow keys, without and with shift
const SECOND = 2;           // a value that comes once a second holds so long, seconds

const data = await unpack(byId('data').textContent);
const curves = Object.fromEntries(Object.entries(data.curves).map(([name, columns]) => [
  name, Object.fromEntries(Object.entries(columns).map(([key, column]) => [key, decode(column)]))]));
const { odom, commands, battery, link } = curves;

const map = new Map2D(byId('map-canvas'), byId('map-key'), ['track', 'bump', 'cliff', 'wheel drop']);
const track = new ReplayTrack(odom, name => map.color(name));
map.track = track;
map.setFollow(false);
byId('no-track').hidden = track.points.length > 0;
map.mark(data.spans.flatMap(({ name, spans }) => (SIGNS[name] ? spans.flatMap(([start]) => {
  const pose = odom.t.length ? track.poseAt(start) : null;
  return pose ? [[SIGNS[name], pose.x, pose.y]] : [];
}) : [])));

const line = (curve, key, name, more = {}) => ({
  name, times: curve.t, values: curve[key], hold: SECOND, ...more });
const commanded = { step: true, hold: data.pause };
const charts = new TimeCharts(byId('chart-list'), [
  { title: 'Forward, m/s', digits: 2, least: [-0.05, 0.05], lines: [
    line(odom, 'speed', 'measured', { hold: 0.5 }), line(commands, 'speed', 'commanded', commanded)] },
  { title: 'Turning, rad/s', digits: 2, least: [-0.1, 0.1], lines: [
    line(odom, 'turn', 'measured', { hold: 0.5 }), line(commands, 'turn', 'commanded', commanded)] },
  { title: 'What holds', rows: data.spans },
  { title: 'Battery, V', digits: 1, least: around(battery.volts), lines: [line(battery, 'volts', '')] },
  { title: 'Current, A', digits: 2, least: [-0.2, 0], lines: [line(battery, 'amperes', '')] },
  { title: 'Charge, %', digits: 0, least: [0, 100], lines: [line(battery, 'charge', '')] },
  { title: 'Frames a second', digits: 0, least: [0, 70], lines: [line(link, 'frames', '')] },
  { title: 'Faults a second', digits: 0, least: [0, 5], lines: [
    line(link, 'damaged', 'damaged frames'), line(link, 'garbage', 'garbage bytes')] },
], data.seconds, data.gaps, name => map.color(name), time => seek(time));

function around(values) {
  const first = values.find(Number.isFinite) ?? 15;
  return [first - 0.25, first + 0.25];
}

// Time.

const slider = byId('slider'), rows = [...document.querySelectorAll('#events tr[data-time]')];
const starts = rows.map(row => Number(row.dataset.time));
let now = 0, playing = null;
slider.max = data.seconds;

function seek(time) {
  now = Math.min(data.seconds, Math.max(0, time));
  slider.value = now;
  byId('clock').textContent = clock(now);
  slider.setAttribute('aria-valuetext', clock(now));
  track.until = now;
  const pose = odom.t.length ? track.poseAt(now) : null;
  if (pose) map.move(pose);
  map.light('bump', bumped());
  charts.setTime(now);
  let current = -1;
  starts.forEach((start, at) => { if (start <= now + 1e-3) current = at; });
  rows.forEach((row, at) => row.classList.toggle('current', at === current));
}

function bumped() {
  const bumps = data.spans.find(({ name }) => name === 'bumper').spans;
  const text = bumps.find(([start, end]) => start <= now && now < end)?.[2] || '';
  return { left: text.includes('left'), right: text.includes('right') };
}

function play(on) {
  playing = on ? performance.now() : null;
  byId('play').textContent = on ? '❚❚' : '▶';
  byId('play').setAttribute('aria-label', on ? 'Pause' : 'Play');
  if (on && now >= data.seconds) seek(0);
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
for (const row of document.querySelectorAll('tr[data-time]')) {
  row.querySelector('button').addEventListener('click', () => {
    play(false);
    seek(Number(row.dataset.time));
  });
}

// Buttons.

byId('zoom-in').addEventListener('click', () => map.zoom(1.35));
byId('zoom-out').addEventListener('click', () => map.zoom(1 / 1.35));
byId('zoom-all').addEventListener('click', () => map.showAll());
byId('follow').addEventListener('click', () => map.setFollow(!map.follow));
map.onFollow = state => byId('follow').setAttribute('aria-pressed', String(state));
byId('time-in').addEventListener('click', () => charts.zoom(0.5));
byId('time-out').addEventListener('click', () => charts.zoom(2));
byId('time-all').addEventListener('click', () => charts.show(0, data.seconds));
byId('trouble').textContent = data.damage;
byId('trouble').hidden = !data.damage;
matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => charts.recolor());

map.showAll();
seek(0);
