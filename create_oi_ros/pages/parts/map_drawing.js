// Copyright 2026 create_oi_ros contributors
// SPDX-License-Identifier: Apache-2.0
// What is drawn on the map, in scale: the room, the robot, rings, and signs. Each kind of sign has a
// shape of its own: nobody needs the colours.

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

// The robot, where it really is, and how sure the odometry is of its place.

const SIGMAS = 2;           // of the ellipse
const LEAST_ARROW = 9;      // pixels: the arrow is seen from afar

export function drawRobot(c, { x, y, yaw }, radius, bump, color, pixel) {
  c.save();
  c.translate(x, y);
  c.rotate(yaw);
  c.lineWidth = 2 * pixel;
  c.fillStyle = color('--robot');
  c.strokeStyle = color('--ink');
  c.beginPath();
  c.arc(0, 0, radius, 0, 7);
  c.fill();
  c.stroke();
  for (const [on, from, to] of [[bump.left, 0, Math.PI / 2], [bump.right, -Math.PI / 2, 0]]) {
    if (!on) continue;
    c.strokeStyle = color('--bump');
    c.lineWidth = Math.max(0.035, 5 * pixel);
    c.beginPath();
    c.arc(0, 0, radius, from, to);
    c.stroke();
  }
  const arrow = Math.max(radius, LEAST_ARROW * pixel);
  c.fillStyle = color('--ink');
  c.beginPath();
  c.moveTo(0.8 * arrow, 0);
  c.lineTo(-0.45 * arrow, 0.45 * arrow);
  c.lineTo(-0.2 * arrow, 0);
  c.lineTo(-0.45 * arrow, -0.45 * arrow);
  c.closePath();
  c.fill();
  c.restore();
}

// A dashed ring with a heading, as [x, y, yaw].
export function drawRing(c, [x, y, yaw], radius, color, pixel) {
  c.strokeStyle = color;
  c.lineWidth = 2 * pixel;
  c.setLineDash([4 * pixel, 4 * pixel]);
  c.beginPath();
  c.arc(x, y, radius, 0, 7);
  if (yaw !== null) {
    c.moveTo(x, y);
    c.lineTo(x + radius * Math.cos(yaw), y + radius * Math.sin(yaw));
  }
  c.stroke();
  c.setLineDash([]);
}

export function drawEllipse(c, { x, y }, [xx, xy, yy], color, pixel) {
  if ([xx, xy, yy].some(each => each === null)) return;
  const middle = (xx + yy) / 2;
  const apart = Math.hypot((xx - yy) / 2, xy);
  const [long, short] = [middle + apart, Math.max(0, middle - apart)]
    .map(variance => SIGMAS * Math.sqrt(variance));
  c.fillStyle = color('--doubt');
  c.strokeStyle = color('--doubt-edge');
  c.lineWidth = 1.5 * pixel;
  c.beginPath();
  c.ellipse(x, y, long, short, Math.atan2(2 * xy, xx - yy) / 2, 0, 7);
  c.fill();
  c.stroke();
}

// Signs.

export const SIGNS = {
  bump: ['bump', '--bump'], cliff: ['cliff', '--cliff'], drop: ['wheel drop', '--drop'],
};

export function sign(c, kind, color, edge) {
  for (const [style, width] of [[edge, 5], [color, 2.5]]) {
    c.strokeStyle = style;
    c.lineWidth = width;
    c.lineCap = c.lineJoin = 'round';
    c.beginPath();
    if (kind === 'bump') { c.moveTo(-5, -5); c.lineTo(5, 5); c.moveTo(-5, 5); c.lineTo(5, -5); }
    else if (kind === 'cliff') { c.moveTo(-6, -4); c.lineTo(6, -4); c.lineTo(0, 6); c.closePath(); }
    else c.rect(-5, -5, 10, 10);
    c.stroke();
  }
}

function line(c, color, dash, width = 2.5) {
  c.strokeStyle = color;
  c.lineWidth = width;
  c.setLineDash(dash);
  c.beginPath(); c.moveTo(-8, 0); c.lineTo(8, 0); c.stroke();
}

function ring(c, color, fill, dash) {
  c.strokeStyle = color;
  c.fillStyle = fill;
  c.lineWidth = 1.5;
  c.setLineDash(dash);
  c.beginPath(); c.arc(0, 0, 7, 0, 7); c.fill(); c.stroke();
}

// The key below the map: the same signs with their names.
export function fillKey(list, color, names) {
  list.replaceChildren();
  const entries = [
    ['track', c => line(c, color('--track'), [])],
    ['2σ of the place', c => ring(c, color('--doubt-edge'), color('--doubt'), [])],
    ['true place', c => ring(c, color('--truth'), 'transparent', [3, 3]), 'simulated'],
    ['Home Base', c => line(c, color('--accent'), [], 6), 'simulated'],
    ['virtual wall', c => line(c, color('--virtual'), [2, 5]), 'simulated'],
    ...Object.entries(SIGNS).map(([kind, [name, tint]]) =>
      [name, c => sign(c, kind, color(tint), color('--card'))]),
  ];
  for (const [name, paint, only] of entries) {
    if (names && !names.includes(name)) continue;
    const item = document.createElement('li');
    const canvas = document.createElement('canvas');
    const ratio = devicePixelRatio || 1;
    canvas.width = canvas.height = 18 * ratio;
    const c = canvas.getContext('2d');
    c.setTransform(ratio, 0, 0, ratio, 9 * ratio, 9 * ratio);
    paint(c);
    item.append(canvas, name);
    if (only) item.className = only;
    list.append(item);
  }
}
