// Copyright 2026 create_oi_ros contributors
// SPDX-License-Identifier: Apache-2.0
// The robot's track as it is drawn: in chunks, of which only those in view are drawn.

const CHUNK = 400;          // points that are drawn, or left out, together

export class Track {
  constructor() {
    this.chunks = [];
    this.rebuilt = 0;
  }

  // Points come as x, y, x, y, ...
  begin(flat) {
    this.chunks = [];
    this.rebuilt += 1;
    this.extend(flat);
  }

  extend(flat) {
    for (let at = 0; at < flat.length; at += 2) this.append([flat[at], flat[at + 1]]);
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

export function box(xs, ys) {
  const least = values => values.reduce((a, b) => Math.min(a, b));
  const most = values => values.reduce((a, b) => Math.max(a, b));
  return { left: least(xs), right: most(xs), low: least(ys), high: most(ys) };
}
