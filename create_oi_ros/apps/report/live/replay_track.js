// Copyright 2026 create_oi_ros contributors
// SPDX-License-Identifier: Apache-2.0
// The track of a recording in colours over time: all of it pale, and strong up to the time shown.

import { indexAt } from './charts.js';
import { Track } from './map_track.js';

const STEP = 0.004;  // metres between two points that are drawn, at least
const MOST = 20000;  // points that are drawn
const HOLD = 0.5;    // seconds without a pose through which the robot does not move
const TINTS = 48;    // colours along the track
const STOPS = ['--time-0', '--time-1', '--time-2', '--time-3'];

export class ReplayTrack extends Track {
  // The line is broken at `jumps`, times at which the odometry began elsewhere, and at gaps.
  constructor(odom, jumps) {
    super();
    Object.assign(this, { odom, jumps });
    this.times = [];    // of the points
    this.until = 0;
    const apart = Math.max(STEP, this.length() / MOST);
    const { t, x, y, yaw } = odom, whole = t.at(-1) - t[0] || 1;
    let whereabouts = null;  // index of the frame before
    t.forEach((time, at) => {
      if (![x[at], y[at], yaw[at]].every(Number.isFinite)) return;
      const last = this.points.at(-1), broken = whereabouts === null || this.broken(whereabouts, at);
      whereabouts = at;
      if (!broken && Math.hypot(x[at] - last[0], y[at] - last[1]) < apart) return;
      this.times.push(time);
      this.append([x[at], y[at]], Math.round((time - t[0]) / whole * TINTS) / TINTS, broken);
      const chunk = this.chunks.at(-1);
      chunk.first ??= this.points.length - (broken ? 1 : 2);
      chunk.end = this.points.length;
    });
  }

  // Whether the odometry jumps, or pauses, between two frames.
  broken(before, at) {
    const from = this.odom.t[before], to = this.odom.t[at];
    return to - from > HOLD || indexAt(this.jumps, from) !== indexAt(this.jumps, to);
  }

  length() {
    const { x, y } = this.odom;
    return x.reduce((sum, each, at) => {
      const step = at ? Math.hypot(each - x[at - 1], y[at] - y[at - 1]) : 0;
      return sum + (Number.isFinite(step) ? step : 0);
    }, 0);
  }

  poseAt(time) {
    const { t, x, y, yaw } = this.odom;
    const at = Math.max(0, indexAt(t, time)), next = Math.min(at + 1, t.length - 1);
    const span = t[next] - t[at];
    const part = span > 0 && !this.broken(at, next) ? Math.max(0, (time - t[at]) / span) : 0;
    const turn = Math.atan2(Math.sin(yaw[next] - yaw[at]), Math.cos(yaw[next] - yaw[at]));
    const pose = { x: x[at] + part * (x[next] - x[at]), y: y[at] + part * (y[next] - y[at]),
                   yaw: yaw[at] + part * turn };
    return Object.values(pose).every(Number.isFinite) ? pose : null;
  }

  // The time at which the robot was nearest to a place; null: it never was within `reach` metres.
  timeNear(x, y, reach) {
    let nearest = reach, found = null;
    this.points.forEach(([px, py], at) => {
      const away = Math.hypot(px - x, py - y);
      if (away < nearest) { nearest = away; found = this.times[at]; }
    });
    return found;
  }

  drawStill(pen) {
    pen.c.globalAlpha = 0.25;
    this.stroke(pen, this.chunks);
    pen.c.globalAlpha = 1;
  }

  drawNew(pen) {
    const gone = indexAt(this.times, this.until) + 1;
    const whole = this.chunks.filter(chunk => chunk.end <= gone), next = this.chunks[whole.length];
    this.stroke(pen, whole);
    if (!next) return;
    pen.c.strokeStyle = this.tint(next.part, pen.color);
    pen.c.beginPath();
    this.points.slice(next.first, gone).forEach(([x, y]) => pen.c.lineTo(x, y));
    pen.c.stroke();
  }

  // The colour of a part of the time, 0 to 1.
  tint(part, color) {
    const at = Math.min(part * (STOPS.length - 1), STOPS.length - 1.001), low = Math.floor(at);
    return `color-mix(in srgb, ${color(STOPS[low + 1])} ${(100 * (at - low)).toFixed(1)}%, `
      + `${color(STOPS[low])})`;
  }
}
