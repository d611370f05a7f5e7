// Copyright 2026 create_oi_ros contributors
// SPDX-License-Identifier: Apache-2.0
// The robot's track as it is drawn: in chunks, of which only those in view are drawn.

const RECENT = 600;         // seconds for which every point is kept
const OLD_STEP = 0.2;       // metres between older points
const THIN_EVERY = 60;      // seconds
const CHUNK = 400;          // points that are drawn, or left out, together

export class Track {
  constructor() {
    this.points = [];   // [x, y, time]
    this.chunks = [];
    this.rebuilt = 0;
    this.thinned = seconds();
  }

  begin(flat) {
    const now = seconds();
    this.points = [];
    for (let at = 0; at < flat.length; at += 2) this.points.push([flat[at], flat[at + 1], now]);
    this.rebuild();
  }

  extend(flat) {
    const now = seconds();
    for (let at = 0; at < flat.length; at += 2) {
      const point = [flat[at], flat[at + 1], now];
      this.points.push(point);
      this.append(point);
    }
    if (now - this.thinned > THIN_EVERY) this.thin(now);
  }

  thin(now) {
    this.thinned = now;
    let last = null;
    const kept = this.points.filter(point => {
      const old = now - point[2] > RECENT;
      const near = last && Math.hypot(point[0] - last[0], point[1] - last[1]) < OLD_STEP;
      if (old && near) return false;
      last = point;
      return true;
    });
    if (kept.length === this.points.length) return;
    this.points = kept;
    this.rebuild();
  }

  rebuild() {
    this.chunks = [];
    this.rebuilt += 1;
    for (const point of this.points) this.append(point);
  }

  // A chunk has one `part`, which may stand for a colour; a point that is apart begins a new line.
  append([x, y], part = 0, apart = false) {
    let chunk = this.chunks.at(-1);
    if (!chunk || chunk.count >= CHUNK || chunk.part !== part || apart) {
      const path = new Path2D(), from = apart || !chunk ? { x, y } : chunk;
      path.moveTo(from.x, from.y);
      chunk = { path, part, count: 0, ...box([from.x, x], [from.y, y]) };
      this.chunks.push(chunk);
    }
    chunk.path.lineTo(x, y);
    chunk.count += 1;
    chunk.x = x; chunk.y = y;
    chunk.left = Math.min(chunk.left, x); chunk.right = Math.max(chunk.right, x);
    chunk.low = Math.min(chunk.low, y); chunk.high = Math.max(chunk.high, y);
  }

  stroke(context, view, chunks) {
    for (const chunk of chunks) {
      if (chunk.right < view.left || chunk.left > view.right
          || chunk.high < view.low || chunk.low > view.high) continue;
      context.stroke(chunk.path);
    }
  }

  // Names what `drawStill` draws: all chunks but the last one, which still grows.
  get still() { return `${this.rebuilt}:${this.chunks.length}`; }

  drawStill(context, view) { this.stroke(context, view, this.chunks.slice(0, -1)); }

  // Draw the last chunk, and a line from its end to where the robot is drawn.
  drawNew(context, view, robot) {
    this.stroke(context, view, this.chunks.slice(-1));
    const last = this.chunks.at(-1);
    if (!last || !robot) return;
    context.beginPath();
    context.moveTo(last.x, last.y);
    context.lineTo(robot.x, robot.y);
    context.stroke();
  }

  // Two corners of what the track covers; none if it is empty.
  corners() {
    return this.chunks.flatMap(({ left, right, low, high }) => [[left, low], [right, high]]);
  }
}

function seconds() { return performance.now() / 1000; }

export function box(xs, ys) {
  const least = values => values.reduce((a, b) => Math.min(a, b));
  const most = values => values.reduce((a, b) => Math.max(a, b));
  return { left: least(xs), right: most(xs), low: least(ys), high: most(ys) };
}
