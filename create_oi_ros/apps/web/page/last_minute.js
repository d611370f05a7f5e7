// Copyright 2026 create_oi_ros contributors
// SPDX-License-Identifier: Apache-2.0
// The charts of the live page: the last minute, until the pointer or the button holds them still.

import { Charts } from './charts.js';

const SECONDS = 60;
const GAP = 1;  // seconds without a sample that break a line
const CHARTS = [
  // title, digits, least range, names of the lines: a sample has the time, then a value for each
  ['Speed, m/s', 2, [-0.1, 0.1], ['']],
  ['Turn, rad/s', 2, [-0.2, 0.2], ['']],
  ['Current, A', 2, [-0.5, 0], ['']],
  ['Cliff signals', 0, [0, 200], ['L', 'FL', 'FR', 'R']],
  ['Wall signal', 0, [0, 50], ['']],
];

export class LastMinute {
  constructor(place, pause, color) {
    this.times = [];
    this.columns = [];
    const charts = CHARTS.map(([title, digits, least, names]) => ({
      title, digits, least, lines: names.map(name => {
        const values = [];
        this.columns.push(values);
        return { name, times: this.times, values, hold: GAP };
      }) }));
    this.charts = new Charts(place, charts, color, {
      text: time => `${+(time - this.charts.zero).toFixed(1)} s`, onLooking: () => this.hold(true) });
    this.pause = pause;
    this.hold(false);
    pause.addEventListener('click', () => this.hold(!this.held));
  }

  // Keep what is shown, or go on with what comes.
  hold(held) {
    this.held = held;
    this.pause.textContent = held ? 'Go on' : 'Pause';
    this.pause.setAttribute('aria-pressed', String(held));
    if (!held && this.times.length) this.show();
  }

  add(samples) {
    if (samples.at(-1)[0] < this.times.at(-1)) this.drop(this.times.length);  // another computer's
    for (const [time, ...values] of samples) {
      if (time <= this.times.at(-1)) continue;  // sent again after a reconnection
      this.times.push(time);
      values.forEach((value, at) => this.columns[at].push(value ?? NaN));
    }
    this.show();
  }

  show() {
    const newest = this.times.at(-1), still = this.held || this.charts.hover !== null;
    if (!still) this.drop(this.times.findIndex(time => time >= newest - SECONDS));
    this.charts.extend(this.times[0], newest, still ? 0 : SECONDS);
  }

  drop(count) { for (const each of [this.times, ...this.columns]) each.splice(0, count); }
}
