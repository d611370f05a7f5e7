// Copyright 2026 create_oi_ros contributors
// SPDX-License-Identifier: Apache-2.0
// The robot's track as it is drawn: in chunks.

const CHUNK = 400;  // points in a chunk, at most
const WIDTH = 2.5;  // pixels

export class Track {
  constructor() {
    this.points = [];
    this.chunks = [];
    this.rebuilt = 0;
  }

  // Points come as x, y, x, y, ...
  begin(flat) {
    this.points = [];
    this.chunks = [];
    this.rebuilt += 1;
    this.extend(flat);
  }

  extend(flat) {
    for (let at = 0; at < flat.length; at += 2) this.append([flat[at], flat[at + 1]]);
  }

  // A chunk has one `part`, which may stand for a colour; a point that is apart begins a new line.
  append(point, part = 0, apart = false) {
    let chunk = this.chunks.at(-1);
    if (!chunk || chunk.count >= CHUNK || chunk.part !== part || apart) {
      chunk = { path: new Path2D(), part, count: 0 };
      if (!apart && this.points.length) chunk.path.moveTo(...this.points.at(-1));
      this.chunks.push(chunk);
    }
    chunk.path.lineTo(...point);
    chunk.count += 1;
    this.points.push(point);
  }

  // Names what `drawStill` draws: all chunks but the last one, which still grows.
  get still() { return `${this.rebuilt}:${this.chunks.length}`; }

  drawStill(pen) { this.stroke(pen, this.chunks.slice(0, -1)); }

  // Draw the last chunk, and a line from its end to where the robot is drawn.
  drawNew(pen, robot) {
    this.stroke(pen, this.chunks.slice(-1));
    if (!this.points.length || !robot) return;
    pen.c.beginPath();
    pen.c.moveTo(...this.points.at(-1));
    pen.c.lineTo(robot.x, robot.y);
    pen.c.stroke();
  }

  stroke({ c, color, pixel }, chunks) {
    c.lineWidth = WIDTH * pixel;
    for (const { part, path } of chunks) {
      c.strokeStyle = this.tint(part, color);
      c.stroke(path);
    }
  }

  tint(part, color) { return color('--track'); }
}
