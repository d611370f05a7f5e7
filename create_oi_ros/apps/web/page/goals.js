// Copyright 2026 create_oi_ros contributors
// SPDX-License-Identifier: Apache-2.0
// Goals: motions with an end. A form for each, places that are tapped on the map, how the newest goal
// fares, and buttons that cancel.

import { byId, element } from './dom.js';
import { forPeople, say, toast } from './panels.js';

const METRES = { unit: 'm' };
const DEGREES = { unit: '°', scale: Math.PI / 180 };
const SPEED = { label: 'At', unit: 'm/s', value: 0.2, min: 0.05 };
const BEHIND = 0.3;   // metres that an undocking robot drives
const TURN = 2 * Math.PI, ARC_STEP = Math.PI / 18;
// For each action: its name, its fields in the form, what is sent, and where the robot gets to on a
// straight way, or by steps on a circle.
const GOALS = {
  drive_distance: {
    title: 'Drive straight',
    fields: { distance: { label: 'Distance', ...METRES, value: 0.5 }, speed: SPEED },
    goal: ({ distance, speed }) => ({ distance, max_translation_speed: speed }),
    way: (pose, { distance }) => [ahead(pose, distance)] },
  rotate_angle: {
    title: 'Turn in place',
    fields: { angle: { label: 'Left', ...DEGREES, value: 90 },
              turn: { label: 'At', unit: '°/s', scale: DEGREES.scale, value: 60, min: 5 } },
    goal: ({ angle, turn }) => ({ angle, max_rotation_speed: turn }) },
  drive_arc: {
    title: 'Drive a circle',
    fields: { angle: { label: 'Left', ...DEGREES, value: 90 },
              radius: { label: 'Radius', ...METRES, value: 0.5, min: 0.1 }, speed: SPEED,
              backward: { label: 'Backward', flag: true } },
    goal: ({ angle, radius, speed, backward }) => ({
      angle, radius, max_translation_speed: speed, translate_direction: backward ? -1 : 1 }),
    way: around },
  navigate_to_position: {
    title: 'Go to a place',
    fields: { x: { label: 'x', ...METRES, value: 0 }, y: { label: 'y', ...METRES, value: 0 },
              heading: { label: 'Then', ...DEGREES, value: '', optional: true }, speed: SPEED },
    hint: 'Or tap places on the map. Then: the heading at the end.',
    goal: ({ x, y, heading, speed }) => ({
      max_translation_speed: speed, achieve_goal_heading: heading !== null,
      goal_pose: { pose: { position: { x, y }, orientation: {
        z: Math.sin(heading / 2), w: Math.cos(heading / 2) } } } }),
    way: (pose, { x, y, heading }) => (x === null || y === null ? [] : [[x, y, heading]]) },
  dock: { title: 'Go and dock', hint: 'It looks for the Home Base, in Passive.' },
  undock: { title: 'Leave the dock', hint: 'Backwards; keep 30 cm behind the robot free.',
            way: pose => [ahead(pose, -BEHIND)] },
};
const STEPS = {
  navigate_state: ['', 'turns to the place', 'drives', 'turns to the heading'],
  state: ['', 'looks for the Home Base', 'sees the Home Base', 'on the contacts', 'charges'],
};
const DRIVES = 2;  // a navigate_state
export const UNDER_WAY = ['sent', 'under way', 'canceling'];
const PLACE = 'navigate_to_position';
const THROUGH = 'The way there leads through a wall';

export class Goals {
  // `speed` returns the speed, m/s, at which places that were tapped are driven to.
  constructor(form, map, send, speed) {
    Object.assign(this, { form, map, send, speed });
    this.name = byId('goal-name');
    this.inputs = {};
    this.total = 0;      // what was left first
    this.places = [];    // tapped, still to be driven to: x and y
    this.tours = false;  // whether the robot is on its way to the first of them
    this.busy = false;
    for (const [name, { title }] of Object.entries(GOALS)) this.name.add(new Option(title, name));
    this.name.addEventListener('change', () => this.choose());
    form.addEventListener('submit', event => {
      event.preventDefault();
      this.begin(this.name.value, this.fields());
    });
    for (const id of ['goal-cancel', 'here-cancel']) {
      byId(id).addEventListener('click', () => this.send('cancel', { what: 'goal' }));
    }
    byId('here-go').addEventListener('click', () => this.next());
    byId('here-clear').addEventListener('click', () => this.setPlaces([]));
    map.onTap = (x, y) => this.setPlaces([...this.places, [x, y]]);
    this.choose();
  }

  begin(name, fields = {}) {
    this.tours = false;
    this.asked = name;   // until it is under way
    this.send(name, GOALS[name].goal?.(fields));
  }

  // Whether `show` tells what a reply is about: it does not when the goal was refused.
  tells(to) {
    const begun = this.asked !== to;
    this.asked = null;
    return to in GOALS && begun;
  }

  setPlaces(places) {
    this.places = places;
    this.showTarget();
  }

  next() {
    const [x, y] = this.places[0];
    this.begin(PLACE, { x, y, heading: null, speed: this.speed() });
    this.tours = true;
  }

  choose() {
    const { fields = {}, hint } = GOALS[this.name.value];
    this.inputs = {};
    const place = byId('goal-fields');
    place.replaceChildren();
    for (const [name, field] of Object.entries(fields)) this.addInput(place, name, field);
    if (hint) element(place, 'p', { className: 'words', textContent: hint });
    this.showTarget();
  }

  addInput(place, name, { label, unit, value, min = '', flag, optional }) {
    const shown = element(place, 'label', { textContent: unit ? `${label}, ${unit}` : label });
    const input = this.inputs[name] = element(shown, 'input', flag ? { type: 'checkbox' } : {
      type: 'number', step: 'any', value, min, required: !optional, inputMode: 'decimal' });
    input.id = `goal-${name}`;
    input.addEventListener('input', () => this.showTarget());
  }

  fields() {
    const found = {};
    for (const [name, { flag, scale = 1 }] of Object.entries(GOALS[this.name.value].fields || {})) {
      const { checked, value } = this.inputs[name];
      found[name] = flag ? checked : value === '' ? null : Number(value) * scale;
    }
    return found;
  }

  // Rings on the map, and what its buttons offer.
  showTarget() {
    const typed = !this.busy && this.map.pose && GOALS[this.name.value].way;
    const way = this.places.length ? this.places.map(place => [...place, null])
      : typed ? typed(this.map.pose, this.fields()) : [];
    const blocked = !this.busy && this.map.isBlocked(way);
    // What is relative to the robot is drawn while the form is in use: else it would go with it.
    const drawn = this.places.length || this.name.value === PLACE || this.form.matches(':hover, :focus-within');
    this.map.set('way', drawn ? way : []);
    const waits = this.places.length > 0 && !this.busy;
    byId('here').hidden = !this.busy && !waits;
    byId('here-go').hidden = byId('here-clear').hidden = !waits;
    byId('here-cancel').hidden = !this.busy;
    say('here-go', this.places.length > 1 ? `Go to ${this.places.length} places` : 'Go here');
    say('here-text', this.busy ? byId('goal-text').textContent : blocked ? `▲ ${THROUGH}` : '');
    say('goal-way', blocked ? `▲ ${THROUGH}` : '');
  }

  show({ name, state, text, feedback }) {
    const ran = this.busy;
    this.busy = UNDER_WAY.includes(state);
    if (this.busy) this.asked = null;
    const { metres, angle } = feedback ? left(feedback) : {};
    const rest = feedback?.navigate_state === undefined ? metres ?? angle : metres;
    if (state === 'sent') this.total = 0;
    if (rest !== undefined) this.total = Math.max(this.total, rest);
    const progress = byId('goal-progress');
    progress.hidden = !this.busy || rest === undefined || !this.total;
    if (!progress.hidden) progress.value = 1 - rest / this.total;
    byId('goal-cancel').disabled = !this.busy || state === 'canceling';
    const mark = { reached: '✓ ', ended: '▲ ' }[state] || '';
    const words = feedback ? inWords(feedback)
      : { reached: 'reached', canceled: 'cancelled', ended: forPeople(text) }[state] || state;
    say('goal-text', `${mark}${GOALS[name].title}: ${words}`);
    byId('goal-text').title = text;
    byId('goal-text').dataset.level = { reached: 'good', ended: 'error' }[state] || '';
    if (ran && !this.busy) toast(byId('goal-text').textContent, state !== 'ended');
    if (!this.busy && this.tours) {
      this.tours = false;
      if (state === 'reached') this.places = this.places.slice(1);
      if (state === 'reached' && this.places.length) this.next();
    }
    this.showTarget();
  }
}

function ahead({ x, y, yaw }, metres) {
  return [x + metres * Math.cos(yaw), y + metres * Math.sin(yaw), null];
}

// Places on a circle, left around for angles above 0, of one turn at most.
function around(pose, { angle, radius, backward }) {
  const turn = Math.max(-TURN, Math.min(TURN, angle)), steps = Math.ceil(Math.abs(turn) / ARC_STEP);
  const side = (turn < 0) === backward ? 1 : -1;  // of the robot on which the centre is: 1 is left
  return Array.from({ length: steps }, (_, at) => {
    const yaw = pose.yaw + turn * (at + 1) / steps;
    return [pose.x + side * radius * (Math.sin(yaw) - Math.sin(pose.yaw)),
            pose.y - side * radius * (Math.cos(yaw) - Math.cos(pose.yaw)),
            ...(at === steps - 1 ? [null] : [])];
  });
}

// What is left to do now: metres, or radians; a goal that goes to a place turns, drives and turns.
function left({ navigate_state: state, remaining_travel_distance: metres,
                remaining_angle_travel: angle }) {
  const drives = state === undefined || state === DRIVES;
  return { metres: drives ? metres : undefined, angle: state === DRIVES ? undefined : angle };
}

function inWords(feedback) {
  const { metres, angle } = left(feedback);
  const words = Object.entries(STEPS).map(([field, names]) => names[feedback[field]]);
  if (metres !== undefined) words.push(`${metres.toFixed(2)} m left`);
  if (angle !== undefined) words.push(`${Math.round(angle * 180 / Math.PI)}° left`);
  if (feedback.red_buoy) words.push('red beam');
  if (feedback.green_buoy) words.push('green beam');
  return words.filter(Boolean).join(', ');
}
