// Copyright 2026 create_oi_ros contributors
// SPDX-License-Identifier: Apache-2.0
// Goals: motions with an end. A form for each, how the newest one fares, and a button that cancels.

import { byId, say } from './panels.js';

const METRES = { unit: 'm' };
const DEGREES = { unit: '°', scale: Math.PI / 180 };
const SPEED = { label: 'At', unit: 'm/s', value: 0.2, min: 0.05 };
const GOALS = {
  drive_distance: ['Drive straight', {
    distance: { label: 'Distance', ...METRES, value: 0.5 }, speed: SPEED }],
  rotate_angle: ['Turn in place', {
    angle: { label: 'Left', ...DEGREES, value: 90 },
    turn: { label: 'At', unit: '°/s', scale: DEGREES.scale, value: 60, min: 5 } }],
  drive_arc: ['Drive a circle', {
    angle: { label: 'Left', ...DEGREES, value: 90 },
    radius: { label: 'Radius', ...METRES, value: 0.5, min: 0.1 }, speed: SPEED,
    backward: { label: 'Backward', flag: true } }],
  navigate_to_position: ['Go to a place', {
    x: { label: 'x', ...METRES, value: 0 }, y: { label: 'y', ...METRES, value: 0 },
    heading: { label: 'Then', ...DEGREES, value: '', optional: true }, speed: SPEED },
    'Or tap the place on the map. Then: the heading at the end.'],
  dock: ['Go and dock', {}, 'It looks for the Home Base, in Passive.'],
  undock: ['Leave the dock', {}, 'Backwards; keep 30 cm behind the robot free.'],
  wall_follow: ['Follow a wall', {
    seconds: { label: 'For', unit: 's', value: 60, min: 10 } }, 'On its right side.'],
};
const STEPS = {
  navigate_state: ['', 'turns to the place', 'drives', 'turns to the heading'],
  state: ['', 'looks for the Home Base', 'sees the Home Base', 'on the contacts', 'charges'],
};
const DRIVES = 2;  // a navigate_state
const UNDER_WAY = ['sent', 'under way', 'canceling'];

export class Goals {
  constructor(form, map, send) {
    Object.assign(this, { form, map, send });
    this.name = byId('goal-name');
    this.inputs = {};
    this.total = 0;     // what was left first
    for (const [name, [title]] of Object.entries(GOALS)) this.name.add(new Option(title, name));
    this.name.addEventListener('change', () => this.choose());
    form.addEventListener('submit', event => {
      event.preventDefault();
      this.send(this.name.value, this.fields());
    });
    byId('goal-cancel').addEventListener('click', () => this.send('cancel'));
    map.onTap = (x, y) => this.aim(x, y);
    this.choose();
  }

  choose() {
    const [, fields, hint = ''] = GOALS[this.name.value];
    this.inputs = {};
    byId('goal-fields').replaceChildren(
      ...Object.entries(fields).map(([name, field]) => this.input(name, field)));
    if (hint) {
      const words = document.createElement('p');
      words.className = 'words';
      words.textContent = hint;
      byId('goal-fields').append(words);
    }
    this.showTarget();
  }

  input(name, { label, unit, value, min, flag, optional }) {
    const input = document.createElement('input');
    input.type = flag ? 'checkbox' : 'number';
    if (!flag) Object.assign(input, { step: 'any', value, required: !optional, inputMode: 'decimal' });
    if (min) input.min = min;
    input.id = `goal-${name}`;
    input.addEventListener('input', () => this.showTarget());
    const shown = document.createElement('label');
    shown.append(unit ? `${label}, ${unit}` : label, input);
    this.inputs[name] = input;
    return shown;
  }

  fields() {
    const found = {};
    for (const [name, { flag, scale = 1 }] of Object.entries(GOALS[this.name.value][1])) {
      const { checked, value } = this.inputs[name];
      found[name] = flag ? checked : value === '' ? null : Number(value) * scale;
    }
    return found;
  }

  // A place that is tapped is a goal only when its form is chosen.
  aim(x, y) {
    if (this.name.value !== 'navigate_to_position') return;
    this.inputs.x.value = x.toFixed(2);
    this.inputs.y.value = y.toFixed(2);
    this.showTarget();
  }

  showTarget() {
    const { x, y, heading } = this.fields();
    const known = this.name.value === 'navigate_to_position' && x !== null && y !== null;
    this.map.set('target', known ? [x, y, heading] : null);
  }

  show({ name, state, text, feedback }) {
    const busy = UNDER_WAY.includes(state);
    const { metres, angle } = feedback ? left(feedback) : {};
    const rest = feedback?.navigate_state === undefined ? metres ?? angle : metres;
    if (state === 'sent') this.total = 0;
    if (rest !== undefined) this.total = Math.max(this.total, rest);
    const progress = byId('goal-progress');
    progress.hidden = !busy || rest === undefined || !this.total;
    if (!progress.hidden) progress.value = 1 - rest / this.total;
    byId('goal-cancel').disabled = !busy || state === 'canceling';
    const mark = { reached: '✓ ', ended: '▲ ' }[state] || '';
    const words = feedback ? inWords(feedback) : text;
    say('goal-text', `${mark}${GOALS[name][0]}: ${words || state}`);
    byId('goal-text').dataset.level = { reached: 'good', ended: 'error' }[state] || '';
  }
}

// What is left to do now: metres, or radians; a goal that goes to a place turns, drives and turns.
function left({ navigate_state: state, remaining_travel_distance: metres,
                remaining_angle_travel: angle }) {
  const drives = state === undefined || state === DRIVES;
  return { metres: drives ? metres : undefined, angle: state === DRIVES ? undefined : angle };
}

function inWords(feedback) {
  const { metres, angle } = left(feedback), { engaged } = feedback;
  const words = Object.entries(STEPS).map(([field, names]) => names[feedback[field]]);
  if (metres !== undefined) words.push(`${metres.toFixed(2)} m left`);
  if (angle !== undefined) words.push(`${Math.round(angle * 180 / Math.PI)}° left`);
  if (engaged !== undefined) words.push(engaged ? 'follows a wall' : 'looks for a wall');
  if (feedback.red_buoy) words.push('red beam');
  if (feedback.green_buoy) words.push('green beam');
  return words.filter(Boolean).join(', ');
}
