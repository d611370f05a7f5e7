// Copyright 2026 create_oi_ros contributors
// SPDX-License-Identifier: Apache-2.0
// The track of a recording: all of it thin, and strong up to the time that is shown.

import { indexAt } from './curves.js';
import { CHUNK, Track } from './map_track.js';

const STEP = 0.004;  // metres between two points that are drawn, at least
const MOST = 20000;  // points that are drawn
const HOLD = 0.5;    // seconds without a pose through which the robot does not move

export class ReplayTrack extends Track {
  constructor(odom, color) {
    super();
    Object.assign(this, { odom, color });
    this.times = [];
    this.until = 0;
    const apart = Math.max(STEP, this.length() / MOST);
    odom.t.forEach((time, at) => {
      const point = [odom.x[at], odom.y[at], time], last = this.points.at(-1);
      if (!point.every(Number.isFinite) || !Number.isFinite(odom.yaw[at])) return;
      if (last && Math.hypot(point[0] - last[0], point[1] - last[1]) < apart) return;
      this.points.push(point);
      this.times.push(time);
      this.append(point);
    });
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
    const part = span > 0 && span < HOLD ? Math.min(1, Math.max(0, (time - t[at]) / span)) : 0;
    const turn = Math.atan2(Math.sin(yaw[next] - yaw[at]), Math.cos(yaw[next] - yaw[at]));
    const pose = { x: x[at] + part * (x[next] - x[at]), y: y[at] + part * (y[next] - y[at]),
                   yaw: yaw[at] + part * turn };
    return Object.values(pose).every(Number.isFinite) ? pose : null;
  }

  drawStill(context, view) {
    context.strokeStyle = this.color('--line');
    this.stroke(context, view, this.chunks);
  }

  drawNew(context, view, robot) {
    const gone = indexAt(this.times, this.until) + 1, whole = Math.floor(gone / CHUNK);
    this.stroke(context, view, this.chunks.slice(0, whole));
    const rest = this.points.slice(Math.max(0, whole * CHUNK - 1), gone);
    if (!rest.length) return;
    context.beginPath();
    rest.forEach(([x, y], at) => context[at ? 'lineTo' : 'moveTo'](x, y));
    if (robot) context.lineTo(robot.x, robot.y);
    context.stroke();
  }
}
