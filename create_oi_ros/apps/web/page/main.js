// Copyright 2026 create_oi_ros contributors
// SPDX-License-Identifier: Apache-2.0
// The page: connects what the server says with what is drawn, and buttons with what is sent.

import { Body } from './body.js';
import { Connection } from './connection.js';
import { byId } from './dom.js';
import { Goals } from './goals.js';
import { LastMinute } from './last_minute.js';
import { Map2D } from './map.js';
import { Music } from './music.js';
import * as panels from './panels.js';
import { Stick } from './stick.js';
import { whyNot } from './why.js';

const { say, toast } = panels;
const DONE = {
  set_mode: 'Mode changed', set_leds: 'LEDs set', reset_odometry: 'Odometry begins here', stop: 'Stopped',
};
const FULL = 3;         // a mode
const LED_DELAY = 120;  // ms: a slider that is dragged sends no more often
const HOLD = 800;       // ms that a button is held which could do harm
const BUZZ = { bump: 80, cliff: [80, 60, 80], drop: [80, 60, 80], battery: [200, 100, 200] };  // ms
const LOW = 0.2;        // of the battery

const map = new Map2D(byId('map-canvas'), byId('map-key'));
const body = new Body(byId('body'), byId('sensed'));
const charts = new LastMinute(byId('chart-list'), byId('chart-pause'), name => map.color(name));
const goals = new Goals(byId('goal-form'), map, send, () => Number(byId('limit').value));
const robot = {};  // what the server told, by its parts
let trouble = '', stopSent = false;

const connection = new Connection(message => RECEIVE[message.type](message), showState);
const stick = new Stick(byId('stick'), byId('knob'), byId('limit'), connection, () => robot.topTurn, stop);
const music = new Music(send);

const RECEIVE = { hello: greet, reply, news: tell };

function send(type, fields) { return connection.send(type, fields); }

function greet({ you, top_speed: topSpeed, top_turn: topTurn, radius, separation,
                 oldest_view: oldestView }) {
  Object.assign(robot, { you, topTurn, separation, oldestView, pose: undefined });
  byId('limit').max = topSpeed;
  map.set('radius', radius);
  byId('log-list').replaceChildren();  // it is sent again, whole
  if (stopSent) send('stop');  // it may have been lost
}

function reply({ to, ok, text }) {
  if (to === 'stop') showStop(false);
  if (to === 'drive' || music.answered(to, ok, text) || goals.tells(to)) return;  // said elsewhere
  toast(ok ? DONE[to] || to : text, ok);
}

const TELL = {
  anew: flat => map.begin(flat),
  track: flat => map.extend(flat),
  events: events => map.mark(events),
  samples: samples => charts.add(samples),
  log: entries => panels.addToLog(entries, connection.seen),
  pose: pose => {
    map.move(pose);
    goals.showTarget();
    panels.showPose(pose, robot.separation);
  },
  ...Object.fromEntries(['bump', 'cliff', 'drop', 'wall', 'overcurrent', 'buttons'].map(
    group => [group, sides => light(group, sides)])),
  room: room => {
    map.set('room', room);
    document.body.classList.add('simulated');
  },
  room_origin: origin => map.set('origin', origin),
  true_pose: pose => map.set('truth', pose),
  mode: panels.showMode,
  battery: battery => {
    panels.showBattery(battery);
    notice('battery', battery.part !== null && battery.part < LOW);
  },
  charging: panels.showCharger,
  infrared: panels.showInfrared,
  song: song => music.sing(song),
  tune: tune => music.show(tune),
  goal: goal => {
    goals.show(goal);
    robot.goalRuns = goals.busy;
  },
  recording: panels.showRecording,
  old: panels.showOld,
  diagnostics: statuses => { trouble = panels.showDiagnostics(statuses); },
  seat: seat => {
    panels.showSeat(seat, robot.you);
    if (seat.stopped && stick.timer !== null) {
      stick.letGo();
      toast('STOP was pressed', false);
    }
  },
};

function tell(news) {
  Object.assign(robot, news);
  // A new track begins before its events.
  for (const name of Object.keys(TELL)) {
    if (news[name] !== undefined) TELL[name](news[name]);
  }
  showState();
}

function light(group, sides) {
  body.light(group, sides);
  if (group === 'bump') map.set('bump', sides);
  notice(group, Object.values(sides).some(Boolean));
}

// A phone in the hand trembles when something begins that its owner may not see.
const noticed = {};
function notice(name, on) {
  const begins = on && noticed[name] === false;
  noticed[name] = on;
  if (begins && BUZZ[name] && navigator.userActivation?.hasBeenActive) navigator.vibrate?.(BUZZ[name]);
}

function showState() {
  if (!connection.live && stick.timer !== null) stick.letGo();
  const hint = panels.showConnection(connection, robot);
  const text = hint || trouble;
  say('banner-text', text);
  byId('banner').hidden = !text;
  byId('banner').dataset.level = hint ? 'error' : 'warn';
  byId('banner-token').hidden = !connection.refused;
  panels.showWhy(whyNot(robot, connection, stick), send);
  if (stick.timer !== null || goals.busy) localStorage.setItem('knows', 'yes');
  byId('first').hidden = localStorage.getItem('knows') !== null;
}

// STOP.

function stop() {
  stick.letGo();
  send('stop');
  showStop(true);
}

// Until the server has answered, nobody knows that it heard.
function showStop(sent) {
  stopSent = sent;
  byId('stop').classList.toggle('pressed', sent);
  byId('stop-text').hidden = !sent;
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
    const button = { '+': 'zoom-in', '=': 'zoom-in', '-': 'zoom-out', f: 'follow', 0: 'zoom-all' }[event.key];
    if (button) byId(button).click();
  }
});

// Who drives, and how fast.

byId('leave').addEventListener('click', () => send('leave'));
const showLimit = () => say('limit-text', `${Number(byId('limit').value).toFixed(2)} m/s`);
byId('limit').addEventListener('input', () => {
  localStorage.setItem('limit', byId('limit').value);
  showLimit();
});
byId('limit').value = localStorage.getItem('limit') || byId('limit').value;
showLimit();

// Doing.

byId('dock').addEventListener('click', () => goals.begin('dock'));
for (const button of byId('modes').children) {
  const mode = Number(button.value);
  if (mode === FULL) whenHeld(button, () => send('set_mode', { mode }));
  else button.addEventListener('click', () => send('set_mode', { mode }));
}

// Act only when a button is held for a while, by finger, mouse or key.
function whenHeld(button, act) {
  let timer = null;
  const begin = event => {
    if (event.repeat || (event.key && event.key !== 'Enter')) return;
    // A banner may move the button away from a mouse that holds it.
    if (event.pointerId !== undefined) button.setPointerCapture(event.pointerId);
    timer ??= setTimeout(() => { timer = null; button.classList.remove('holding'); act(); }, HOLD);
    button.classList.add('holding');
  };
  const end = () => {
    if (timer !== null) toast(`Hold it: ${button.title}`, false);
    clearTimeout(timer);
    timer = null;
    button.classList.remove('holding');
  };
  for (const name of ['pointerdown', 'keydown']) button.addEventListener(name, begin);
  for (const name of ['pointerup', 'pointerleave', 'pointercancel', 'keyup', 'blur']) {
    button.addEventListener(name, end);
  }
  button.addEventListener('contextmenu', event => event.preventDefault());
}

byId('record').addEventListener(
  'click', () => send('record', { on: robot.recording?.state !== 'on' }));

let ledTimer = null;
function sendLeds() {
  ledTimer = null;
  send('set_leds', {
    play: byId('led-play').checked, advance: byId('led-advance').checked,
    power_color: Number(byId('led-color').value),
    power_intensity: Number(byId('led-intensity').value),
  });
}
for (const id of ['led-play', 'led-advance', 'led-color', 'led-intensity']) {
  byId(id).addEventListener('input', () => { ledTimer ??= setTimeout(sendLeds, LED_DELAY); });
}
byId('reset').addEventListener('click', () => send('reset_odometry'));
