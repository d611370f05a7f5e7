// Copyright 2026 create_oi_ros contributors
// SPDX-License-Identifier: Apache-2.0
// What is drawn on the map, in scale: the room, the robot, rings, and signs. Each kind of sign has a
// shape of its own: nobody needs the colours.

import { element } from './dom.js';

const HOME_BASE = [-0.03, -0.1, 0.06, 0.2];  // a rectangle, metres
const SIGMAS = 2;       // of the ellipse
const LEAST_ARROW = 9;  // pixels: the arrow is seen from afar
const ARROW = [0.8, 0, -0.45, 0.45, -0.2, 0, -0.45, -0.45];  // x, y, ... for a radius of 1

// Draws on a canvas: `pixel` is the size of one in its units, `color` returns a colour by its name.
export class Pen {
  constructor(c, color, pixel = 1) { Object.assign(this, { c, color, pixel }); }

  // Fill and stroke what `path` adds to the canvas; width and dash are in pixels.
  draw(path, { fill, stroke, width = 2, dash = [] }) {
    const { c, color, pixel } = this;
    c.beginPath();
    path(c);
    if (fill) {
      c.fillStyle = color(fill);
      c.fill();
    }
    if (!stroke) return;
    c.strokeStyle = color(stroke);
    c.lineWidth = width * pixel;
    c.setLineDash(dash.map(each => each * pixel));
    c.stroke();
    c.setLineDash([]);
  }

  // Draw with the origin at another place, turned by `yaw`.
  at([x, y, yaw], draw) {
    this.c.save();
    this.c.translate(x, y);
    this.c.rotate(yaw);
    draw();
    this.c.restore();
  }
}

export function drawRoom(pen, room, origin) {
  const cliff = { stroke: '--cliff', dash: [6, 5] };
  pen.at(origin, () => {
    for (const each of room.cliffs) pen.draw(c => polygon(c, each), { fill: '--pit', ...cliff });
    for (const each of room.grounds) pen.draw(c => polygon(c, each), cliff);
    for (const [x, y, yaw, reach] of room.virtual_walls) {
      pen.draw(c => ray(c, x, y, yaw, reach), { stroke: '--virtual', dash: [2, 5] });
    }
    pen.draw(c => {
      for (const [ax, ay, bx, by] of room.walls) { c.moveTo(ax, ay); c.lineTo(bx, by); }
    }, { stroke: '--room', width: Math.max(0.03 / pen.pixel, 2) });
    for (const [x, y, radius] of room.posts) {
      pen.draw(c => c.arc(x, y, radius, 0, 7), { fill: '--room' });
    }
    for (const base of room.home_bases) {
      pen.at(base, () => pen.draw(c => c.rect(...HOME_BASE), { fill: '--accent' }));
    }
  });
}

function polygon(c, flat) {
  for (const [x, y] of pairs(flat)) c.lineTo(x, y);
  c.closePath();
}

function ray(c, x, y, yaw, reach) {
  c.moveTo(x, y);
  c.lineTo(x + reach * Math.cos(yaw), y + reach * Math.sin(yaw));
}

// Whether a robot of this radius, on its straight way between two places, meets a wall or a post.
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

export function drawRobot(pen, { x, y, yaw }, radius, bump = {}) {
  const edge = { stroke: '--bump', width: Math.max(0.035 / pen.pixel, 5) };
  const arrow = Math.max(radius, LEAST_ARROW * pen.pixel);
  pen.at([x, y, yaw], () => {
    pen.draw(c => c.arc(0, 0, radius, 0, 7), { fill: '--robot', stroke: '--ink' });
    if (bump.left) pen.draw(c => c.arc(0, 0, radius, 0, Math.PI / 2), edge);
    if (bump.right) pen.draw(c => c.arc(0, 0, radius, -Math.PI / 2, 0), edge);
    pen.draw(c => polygon(c, ARROW.map(each => each * arrow)), { fill: '--ink' });
  });
}

// A dashed ring, with a heading unless `yaw` is null.
export function drawRing(pen, [x, y, yaw], radius, color) {
  pen.draw(c => {
    c.arc(x, y, radius, 0, 7);
    if (yaw !== null) ray(c, x, y, yaw, radius);
  }, { stroke: color, dash: [4, 4] });
}

export function drawEllipse(pen, { x, y }, [xx, xy, yy]) {
  if ([xx, xy, yy].some(each => each === null)) return;
  const middle = (xx + yy) / 2;
  const apart = Math.hypot((xx - yy) / 2, xy);
  const [long, short] = [middle + apart, Math.max(0, middle - apart)]
    .map(variance => SIGMAS * Math.sqrt(variance));
  pen.draw(c => c.ellipse(x, y, long, short, Math.atan2(2 * xy, xx - yy) / 2, 0, 7),
           { fill: '--doubt', stroke: '--doubt-edge', width: 1.5 });
}

// Signs by their names, with colours and paths, in pixels.

export const SIGNS = {
  bumper: { color: '--bump', path: c => {
    c.moveTo(-5, -5); c.lineTo(5, 5); c.moveTo(-5, 5); c.lineTo(5, -5);
  } },
  cliff: { color: '--cliff', path: c => polygon(c, [-6, -4, 6, -4, 0, 6]) },
  'wheel drop': { color: '--drop', path: c => c.rect(-5, -5, 10, 10) },
};

export function drawSign(pen, name) {
  const { color, path } = SIGNS[name];
  pen.c.lineCap = pen.c.lineJoin = 'round';
  pen.draw(path, { stroke: '--card', width: 5 });
  pen.draw(path, { stroke: color, width: 2.5 });
}

// The key below the map: the same signs with their names.
export function fillKey(list, color, names) {
  const line = c => { c.moveTo(-8, 0); c.lineTo(8, 0); }, ring = c => c.arc(0, 0, 7, 0, 7);
  const entries = [
    ['track', pen => pen.draw(line, { stroke: '--track' })],
    ['2σ of the place', pen => pen.draw(ring, { fill: '--doubt', stroke: '--doubt-edge' })],
    ['true place', pen => pen.draw(ring, { stroke: '--truth', dash: [3, 3] }), 'simulated'],
    ['Home Base', pen => pen.draw(line, { stroke: '--accent', width: 6 }), 'simulated'],
    ['virtual wall', pen => pen.draw(line, { stroke: '--virtual', dash: [2, 5] }), 'simulated'],
    ...Object.keys(SIGNS).map(name => [name, pen => drawSign(pen, name)]),
  ].filter(([name]) => !names || names.includes(name));
  list.replaceChildren();
  for (const [name, paint, only = ''] of entries) {
    const item = element(list, 'li', { className: only }), ratio = devicePixelRatio || 1;
    const c = element(item, 'canvas', { width: 18 * ratio, height: 18 * ratio }).getContext('2d');
    c.setTransform(ratio, 0, 0, ratio, 9 * ratio, 9 * ratio);
    paint(new Pen(c, color));
    item.append(name);
  }
}
