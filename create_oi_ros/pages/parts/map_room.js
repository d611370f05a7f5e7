// Copyright 2026 create_oi_ros contributors
// SPDX-License-Identifier: Apache-2.0
// The room of a simulated robot: walls, cliffs, virtual walls, Home Bases.

const HOME_BASE = [0.06, 0.2];  // metres, drawn

export function drawRoom(c, room, origin, color, pixel) {
  c.save();
  c.translate(origin[0], origin[1]);
  c.rotate(origin[2]);
  drawCliffs(c, room, color, pixel);
  drawVirtualWalls(c, room, color, pixel);
  c.strokeStyle = color('--room');
  c.fillStyle = color('--room');
  c.lineWidth = Math.max(0.03, 2 * pixel);
  c.beginPath();
  for (const [ax, ay, bx, by] of room.walls) { c.moveTo(ax, ay); c.lineTo(bx, by); }
  c.stroke();
  for (const [x, y, radius] of room.posts) {
    c.beginPath(); c.arc(x, y, radius, 0, 7); c.fill();
  }
  c.fillStyle = color('--accent');
  for (const [x, y, yaw] of room.home_bases) {
    c.save();
    c.translate(x, y);
    c.rotate(yaw);
    c.fillRect(-HOME_BASE[0] / 2, -HOME_BASE[1] / 2, ...HOME_BASE);
    c.restore();
  }
  c.restore();
}

function drawCliffs(c, room, color, pixel) {
  c.strokeStyle = color('--cliff');
  c.fillStyle = color('--pit');
  c.lineWidth = 2 * pixel;
  c.setLineDash([6 * pixel, 5 * pixel]);
  for (const polygon of room.cliffs) { trace(c, pairs(polygon)); c.fill(); c.stroke(); }
  for (const polygon of room.grounds) { trace(c, pairs(polygon)); c.stroke(); }
  c.setLineDash([]);
}

function drawVirtualWalls(c, room, color, pixel) {
  c.setLineDash([2 * pixel, 5 * pixel]);
  c.strokeStyle = color('--virtual');
  c.lineWidth = 2 * pixel;
  for (const [x, y, yaw, reach] of room.virtual_walls) {
    c.beginPath();
    c.moveTo(x, y);
    c.lineTo(x + reach * Math.cos(yaw), y + reach * Math.sin(yaw));
    c.stroke();
  }
  c.setLineDash([]);
}

function trace(c, points) {
  c.beginPath();
  points.forEach(([x, y], at) => c[at ? 'lineTo' : 'moveTo'](x, y));
  c.closePath();
}

// Whether a robot of this radius, on its straight way between two places, would meet a wall or a post.
export function crosses(room, [ox, oy, yaw], from, to, radius) {
  const [cos, sin] = [Math.cos(yaw), Math.sin(yaw)];
  const [a, b] = [from, to].map(([x, y]) => [
    (x - ox) * cos + (y - oy) * sin, (y - oy) * cos - (x - ox) * sin]);
  return room.walls.some(([ax, ay, bx, by]) => gap(a, b, [ax, ay], [bx, by]) < radius)
    || room.posts.some(([x, y, size]) => away([x, y], a, b) < radius + size);
}

// Metres from a place to a stretch, and between two stretches.
function away([x, y], [ax, ay], [bx, by]) {
  const [dx, dy] = [bx - ax, by - ay];
  const part = ((x - ax) * dx + (y - ay) * dy) / (dx * dx + dy * dy || 1);
  const at = Math.min(1, Math.max(0, part));
  return Math.hypot(x - ax - at * dx, y - ay - at * dy);
}

function gap(a, b, c, d) {
  const side = ([px, py], [qx, qy], [x, y]) => Math.sign((qx - px) * (y - py) - (qy - py) * (x - px));
  const cross = side(a, b, c) !== side(a, b, d) && side(c, d, a) !== side(c, d, b);
  return cross ? 0 : Math.min(away(a, c, d), away(b, c, d), away(c, a, b), away(d, a, b));
}

// The corners of a room, as the room's own x and y.
export function cornersOf(room) {
  return [...room.walls.flatMap(pairs), ...room.grounds.flatMap(pairs)];
}

function pairs(flat) {
  return Array.from({ length: flat.length / 2 }, (_, at) => [flat[2 * at], flat[2 * at + 1]]);
}
