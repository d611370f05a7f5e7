// Copyright 2026 create_oi_ros contributors
// SPDX-License-Identifier: Apache-2.0
// The page: connects what the server says with what is drawn, and buttons with what is sent.

import { Body } from './body.js';
import { Connection } from './connection.js';
import { Goals } from './goals.js';
import { LastMinute } from './last_minute.js';
import { Map2D } from './map.js';
import * as panels from './panels.js';
import { Piano } from './piano.js';
import { Stick } from './stick.js';

const { byId, say, toast } = panels;
const DONE = {
  mode: 'Mode changed', song: 'Playing', leds: 'LEDs set',
  reset_odometry: 'Odometry begins here', stop: 'Stopped',
};
const LED_DELAY = 120;  // ms: a slider that is dragged sends no more often

const map = new Map2D(byId('map-canvas'), byId('map-key'));
const body = new Body(byId('body'), byId('sensed'));
const charts = new LastMinute(byId('chart-list'), byId('chart-pause'), name => map.color(name));
const goals = new Goals(byId('goal-form'), map, (type, fields) => connection.send(type, fields));
const known = { you: null, topTurn: 3.8, separation: 0.258, silent: true, found: false, any: false };
let connected = false, trouble = '', problem = '';

const connection = new Connection(receive, (state, why) => {
  connected = state;
  problem = why;
  if (!state) stick.letGo();
  else known.any = false;
  showState();
});
const stick = new Stick(byId('stick'), byId('knob'), byId('limit'), connection, () => known.topTurn);

function receive(message) {
  if (message.type === 'hello') greet(message);
  else if (message.type === 'reply') reply(message);
  else if (message.type === 'news') tell(message);
}

function greet({ you, top_speed: topSpeed, top_turn: topTurn, radius, separation }) {
  Object.assign(known, { you, topTurn, separation });
  byId('limit').max = topSpeed;
  map.set('radius', radius);
}

function reply({ to, ok, text }) {
  if (to === 'drive' && !ok && stick.timer === null) return;  // it was let go meanwhile
  toast(ok ? text || DONE[to] || to : text, ok);
}

const TELL = {
  anew: flat => map.begin(flat),
  track: flat => map.extend(flat),
  events: events => map.mark(events),
  samples: samples => charts.add(samples),
  pose: pose => {
    known.any = true;
    map.move(pose);
    panels.showPose(pose, known.separation);
  },
  bump: sides => light('bump', sides),
  cliff: sides => light('cliff', sides),
  drop: sides => light('drop', sides),
  wall: sides => light('wall', sides),
  overcurrent: sides => light('overcurrent', sides),
  buttons: sides => light('buttons', sides),
  room: room => {
    map.set('room', room);
    document.body.classList.add('simulated');
  },
  room_origin: origin => map.set('origin', origin),
  true_pose: pose => map.set('truth', pose),
  mode: panels.showMode,
  battery: panels.showBattery,
  charging: panels.showCharger,
  infrared: panels.showInfrared,
  goal: goal => goals.show(goal),
  diagnostics: statuses => { trouble = panels.showDiagnostics(statuses); showState(); },
  seat: seat => {
    panels.showSeat(seat, known.you);
    if (seat.stopped && stick.timer !== null) {
      stick.letGo();
      toast('STOP was pressed', false);
    }
  },
  silent: silent => { known.silent = silent; showState(); },
  driver_found: found => { known.found = found; showState(); },
};

function tell(news) {
  // A new track begins before its events.
  for (const name of Object.keys(TELL)) {
    if (news[name] !== undefined) TELL[name](news[name]);
  }
}

function light(group, sides) {
  body.light(group, sides);
  map.light(group, sides);
}

function showState() {
  const hint = panels.showConnection(connected, known.silent, known.found, known.any);
  const text = problem || hint || trouble;
  say('banner', text);
  byId('banner').hidden = !text;
  byId('banner').dataset.level = problem || hint ? 'error' : 'warn';
}

// STOP.

function stop() {
  stick.letGo();
  if (!connection.send('stop')) toast('No connection: the robot stops by itself', false);
  byId('stop').classList.add('pressed');
  setTimeout(() => byId('stop').classList.remove('pressed'), 300);
}
byId('stop').addEventListener('pointerdown', event => {
  if (event.button === 0) stop();
});
byId('stop').addEventListener('click', event => {
  if (event.detail === 0) stop();  // by keyboard: pointers were heard already
});
addEventListener('keydown', event => {
  const inControl = event.target.closest('button, input, select, summary');
  if (event.key === 'Escape' || (event.key === ' ' && !inControl)) {
    event.preventDefault();
    stop();
  } else if (!inControl || event.target.closest('.map-buttons')) {
    const act = { '+': zoomIn, '=': zoomIn, '-': zoomOut, f: follow, a: () => map.showAll() };
    act[event.key]?.();
  }
});

// The map's buttons.

const zoomIn = () => map.zoom(1.35), zoomOut = () => map.zoom(1 / 1.35);
const follow = () => map.setFollow(!map.follow);
byId('zoom-in').addEventListener('click', zoomIn);
byId('zoom-out').addEventListener('click', zoomOut);
byId('zoom-all').addEventListener('click', () => map.showAll());
byId('follow').addEventListener('click', follow);
map.onFollow = state => byId('follow').setAttribute('aria-pressed', String(state));

// Who drives, and how fast.

byId('take').addEventListener('click', () => connection.send('take_over'));
byId('leave').addEventListener('click', () => connection.send('leave'));
const showLimit = () => say('limit-text', `${Number(byId('limit').value).toFixed(2)} m/s`);
byId('limit').addEventListener('input', showLimit);
showLimit();

// Doing.

for (const button of byId('modes').children) {
  button.addEventListener('click', () => connection.send('mode', { mode: button.dataset.mode }));
}
new Piano(byId('piano'), byId('tune'), byId('replay'), notes => connection.send('song', { notes }));

let ledTimer = null;
function sendLeds() {
  ledTimer = null;
  connection.send('leds', {
    play: byId('led-play').checked, advance: byId('led-advance').checked,
    color: Number(byId('led-color').value), intensity: Number(byId('led-intensity').value),
  });
}
for (const id of ['led-play', 'led-advance', 'led-color', 'led-intensity']) {
  byId(id).addEventListener('input', () => { ledTimer ??= setTimeout(sendLeds, LED_DELAY); });
}
byId('reset').addEventListener('click', () => connection.send('reset_odometry'));
