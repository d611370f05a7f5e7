// Copyright 2026 create_oi_ros contributors
// SPDX-License-Identifier: Apache-2.0
// The map: room, track, events, the robot, and how sure the odometry is of its place.

import {
  cornersOf, crosses, drawEllipse, drawRing, drawRobot, drawRoom, fillKey, sign, SIGNS,
} from './map_drawing.js';
import { box, Track } from './map_track.js';

const LEAST_SCALE = 4, MOST_SCALE = 1200, FIRST_SCALE = 90;  // pixels for a metre
const BEYOND = 200;         // pixels around the map that are drawn, too
const ZOOM = 1.35;          // of one step
const TAP = 6;              // pixels that a finger may move while it taps
const EASE = 60;            // ms in which the robot drawn follows the one measured
const NARROW = 0.8;         // of the robot's radius: one that touches a wall can drive along it

export class Map2D {
  // `signs` are the names that the key explains; all, if they are left out.
  constructor(canvas, key, signs) {
    this.canvas = canvas;
    this.context = canvas.getContext('2d');
    this.center = { x: 0, y: 0 };
    this.scale = FIRST_SCALE;
    this.follow = true;
    this.onTap = () => {};      // is told x and y, metres
    this.scrolls = false;       // the wheel scrolls the page, and zooms with Ctrl
    this.track = new Track();
    this.layer = new StillLayer();
    this.changes = 0;           // of what stands still, besides the track
    this.events = [];
    this.pose = this.drawn = this.truth = this.room = this.origin = null;
    this.way = [];              // where goals lead: x, y, and a heading or null where they end
    this.radius = 0.165;
    this.lit = {};
    this.pointers = new Map();
    this.dirty = true;
    this.readColors();
    matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => {
      this.readColors();
      fillKey(key, this.color, signs);
    });
    fillKey(key, this.color, signs);
    this.addButtons();
    new ResizeObserver(() => this.resize()).observe(canvas);
    this.listen();
    this.resize();
    requestAnimationFrame(time => this.frame(time));
  }

  readColors() {
    const style = getComputedStyle(document.documentElement), known = new Map();
    this.color = name => {
      if (!known.has(name)) known.set(name, style.getPropertyValue(name).trim());
      return known.get(name);
    };
    this.changes += 1;
    this.touch();
  }

  touch() { this.dirty = true; }

  addButtons() {
    const place = document.createElement('div');
    place.className = 'map-buttons';
    const button = (id, text, title, act) => {
      const made = document.createElement('button');
      Object.assign(made, { id, textContent: text, title });
      made.addEventListener('click', act);
      place.append(made);
      return made;
    };
    button('zoom-in', '+', 'Zoom in', () => this.zoom(ZOOM)).ariaLabel = 'Zoom in';
    button('zoom-out', '\u2212', 'Zoom out', () => this.zoom(1 / ZOOM)).ariaLabel = 'Zoom out';
    button('zoom-all', 'All', 'Show everything', () => this.showAll());
    this.button = button('follow', 'Follow', 'Keep the robot in the middle',
                         () => this.setFollow(!this.follow));
    this.button.ariaPressed = true;
    this.canvas.after(place);
  }

  // What the robot tells.

  begin(flat) {
    this.track.begin(flat);
    this.events = [];
    this.touch();
  }

  extend(flat) {
    this.track.extend(flat);
    this.touch();
  }

  mark(events) { this.events.push(...events); this.touch(); }

  move(pose) {
    this.pose = pose;
    if (!this.drawn) this.drawn = { x: pose.x, y: pose.y, yaw: pose.yaw };
    this.touch();
  }

  set(name, value) {
    this[name] = value;
    if (name === 'room' || name === 'origin') this.changes += 1;
    this.touch();
  }

  light(group, sides) { this.lit[group] = sides; this.touch(); }

  // Looking.

  listen() {
    const canvas = this.canvas;
    // A finger scrolls the page, two move the map.
    canvas.addEventListener('touchstart', event => {
      if (event.touches.length > 1) event.preventDefault();
    }, { passive: false });
    canvas.addEventListener('wheel', event => {
      if (this.scrolls && !event.ctrlKey && !event.metaKey) return;
      event.preventDefault();
      this.zoom(Math.exp(-event.deltaY / 400), event.offsetX, event.offsetY);
    }, { passive: false });
    canvas.addEventListener('pointerdown', event => {
      canvas.setPointerCapture(event.pointerId);
      this.pointers.set(event.pointerId, [event.offsetX, event.offsetY]);
      this.tapped = this.pointers.size === 1 ? [event.offsetX, event.offsetY] : null;
    });
    canvas.addEventListener('pointermove', event => this.drag(event));
    canvas.addEventListener('pointerup', event => {
      if (this.pointers.delete(event.pointerId) && this.tapped) this.onTap(...this.placeOf(event));
    });
    canvas.addEventListener('pointercancel', event => this.pointers.delete(event.pointerId));
    canvas.addEventListener('dblclick', () => this.setFollow(true));
  }

  drag(event) {
    const before = this.pointers.get(event.pointerId);
    if (!before) return;
    const here = [event.offsetX, event.offsetY];
    if (this.tapped && apart(here, this.tapped) < TAP) return;
    this.tapped = null;
    if (this.pointers.size > 1) {
      const other = [...this.pointers].find(([id]) => id !== event.pointerId)[1];
      const factor = (apart(here, other) || 1) / (apart(before, other) || 1);
      this.zoom(factor, (here[0] + other[0]) / 2, (here[1] + other[1]) / 2);
      this.shift((here[0] - before[0]) / 2, (here[1] - before[1]) / 2);
    } else if (event.pointerType !== 'touch') {
      this.shift(here[0] - before[0], here[1] - before[1]);
    }
    this.pointers.set(event.pointerId, here);
    this.touch();
  }

  shift(right, down) {
    this.setFollow(false);
    this.center.x -= right / this.scale;
    this.center.y += down / this.scale;
  }

  // Zoom so that the place under a pixel stays there; while following, around the robot.
  zoom(factor, px = this.width / 2, py = this.height / 2) {
    const scale = Math.min(MOST_SCALE, Math.max(LEAST_SCALE, this.scale * factor));
    if (!this.follow) {
      const [dx, dy] = [px - this.width / 2, py - this.height / 2];
      this.center.x += dx / this.scale - dx / scale;
      this.center.y -= dy / this.scale - dy / scale;
    }
    this.scale = scale;
    this.touch();
  }

  setFollow(follow) {
    if (follow === this.follow) return;
    this.follow = follow;
    this.button.ariaPressed = follow;
    this.touch();
  }

  showAll() {
    const corners = this.track.corners();
    if (this.pose) corners.push([this.pose.x, this.pose.y]);
    if (this.room && this.origin) {
      corners.push(...cornersOf(this.room).map(corner => this.fromRoom(...corner)));
    }
    if (!corners.length) return;
    const { left, right, low, high } = box(corners.map(c => c[0]), corners.map(c => c[1]));
    this.setFollow(false);
    this.center = { x: (left + right) / 2, y: (low + high) / 2 };
    const margin = 0.6;
    this.scale = Math.max(LEAST_SCALE, Math.min(
      FIRST_SCALE * 2, this.width / (right - left + margin), this.height / (high - low + margin)));
    this.touch();
  }

  placeOf(event) {
    return [this.center.x + (event.offsetX - this.width / 2) / this.scale,
            this.center.y - (event.offsetY - this.height / 2) / this.scale];
  }

  fromRoom(x, y) {
    const [ox, oy, yaw] = this.origin;
    return [ox + x * Math.cos(yaw) - y * Math.sin(yaw), oy + x * Math.sin(yaw) + y * Math.cos(yaw)];
  }

  // Drawing.

  resize() {
    this.width = this.canvas.clientWidth;
    this.height = this.canvas.clientHeight;
    this.ratio = devicePixelRatio || 1;
    this.canvas.width = Math.round(this.width * this.ratio);
    this.canvas.height = Math.round(this.height * this.ratio);
    this.draw();
  }

  frame(time) {
    const moving = this.ease(time - (this.lastFrame || time));
    this.lastFrame = time;
    if (this.dirty || moving) this.draw();
    requestAnimationFrame(next => this.frame(next));
  }

  ease(elapsed) {
    if (!this.pose) return false;
    const { drawn, pose } = this;
    const part = 1 - Math.exp(-elapsed / EASE);
    const turn = Math.atan2(Math.sin(pose.yaw - drawn.yaw), Math.cos(pose.yaw - drawn.yaw));
    const away = Math.hypot(pose.x - drawn.x, pose.y - drawn.y);
    if (away < 2e-4 && Math.abs(turn) < 1e-3) return false;
    const jump = away > 0.5;
    drawn.x += (pose.x - drawn.x) * (jump ? 1 : part);
    drawn.y += (pose.y - drawn.y) * (jump ? 1 : part);
    drawn.yaw += turn * (jump ? 1 : part);
    return true;
  }

  draw() {
    this.dirty = false;
    const { context: c, ratio } = this;
    if (!this.width) return;
    if (this.follow && this.drawn) this.center = { x: this.drawn.x, y: this.drawn.y };
    c.setTransform(1, 0, 0, 1, 0, 0);
    c.clearRect(0, 0, this.canvas.width, this.canvas.height);
    this.pixel = 1 / this.scale;
    this.layer.show(this, [this.changes, this.track.still].join(),
                    (still, view) => this.drawStill(still, view));
    const zoom = this.scale * ratio;
    c.setTransform(zoom, 0, 0, -zoom, this.canvas.width / 2 - this.center.x * zoom,
                   this.canvas.height / 2 + this.center.y * zoom);
    c.lineCap = c.lineJoin = 'round';
    const { color, pixel, radius } = this;
    this.drawTrack(c, () => this.track.drawNew(c, this.view(), this.drawn));
    this.drawWay(c);
    if (this.pose) {
      drawRobot(c, this.drawn, radius, this.lit.bump || {}, color, pixel);
      if (this.pose.covariance) drawEllipse(c, this.drawn, this.pose.covariance, color, pixel);
    }
    for (const event of this.events) this.drawSign(event);
    if (this.truth && this.origin) {
      const [x, y, yaw] = this.truth;
      drawRing(c, [...this.fromRoom(x, y), yaw + this.origin[2]], radius, color('--truth'), pixel);
    }
    c.setTransform(ratio, 0, 0, ratio, 0, 0);
    this.drawScale();
  }

  view() {
    const [w, h] = [this.width / 2 / this.scale, this.height / 2 / this.scale];
    return { left: this.center.x - w, right: this.center.x + w,
             low: this.center.y - h, high: this.center.y + h };
  }

  drawStill(c, view) {
    this.drawGrid(c, view);
    if (this.room && this.origin) drawRoom(c, this.room, this.origin, this.color, this.pixel);
    this.drawTrack(c, () => this.track.drawStill(c, view));
  }

  drawGrid(c, view) {
    const step = this.scale > 30 ? 1 : this.scale > 8 ? 5 : 20;
    c.beginPath();
    for (let x = Math.ceil(view.left / step) * step; x <= view.right; x += step) {
      c.moveTo(x, view.low); c.lineTo(x, view.high);
    }
    for (let y = Math.ceil(view.low / step) * step; y <= view.high; y += step) {
      c.moveTo(view.left, y); c.lineTo(view.right, y);
    }
    c.strokeStyle = this.color('--grid');
    c.lineWidth = this.pixel;
    c.stroke();
  }

  drawTrack(c, draw) {
    c.strokeStyle = this.color('--track');
    c.lineWidth = 2.5 * this.pixel;
    draw();
  }

  // A way from the robot to one place after the other, as pairs of places.
  legs(way) {
    return this.pose ? way.map((to, at) => [way[at - 1] || [this.pose.x, this.pose.y], to]) : [];
  }

  blocks([from, to]) {
    return Boolean(this.room && this.origin) && crosses(this.room, this.origin, from, to, NARROW * this.radius);
  }

  isBlocked(way) { return this.legs(way).some(leg => this.blocks(leg)); }

  drawWay(c) {
    const { color, pixel } = this;
    for (const leg of this.legs(this.way)) {
      const [from, to] = leg, blocked = this.blocks(leg);
      c.strokeStyle = color(blocked ? '--stop' : '--accent');
      c.lineWidth = (blocked ? 4 : 2) * pixel;
      c.beginPath(); c.moveTo(from[0], from[1]); c.lineTo(to[0], to[1]); c.stroke();
      if (to.length > 2) drawRing(c, to, this.radius, color('--accent'), pixel);
    }
  }

  drawSign([kind, x, y]) {
    const c = this.context;
    c.save();
    c.translate(x, y);
    c.scale(this.pixel, -this.pixel);
    sign(c, kind, this.color(SIGNS[kind][1]), this.color('--card'));
    c.restore();
  }

  drawScale() {
    const c = this.context;
    const metres = [0.1, 0.2, 0.5, 1, 2, 5, 10, 20].find(each => each * this.scale >= 50) || 50;
    const long = metres * this.scale, left = 14, low = this.height - 14;
    c.strokeStyle = c.fillStyle = this.color('--ink');
    c.lineWidth = 1.5;
    c.beginPath();
    c.moveTo(left, low - 5); c.lineTo(left, low); c.lineTo(left + long, low);
    c.lineTo(left + long, low - 5);
    c.stroke();
    c.font = '12px system-ui, sans-serif';
    c.fillText(`${metres} m`, left + 4, low - 5);
  }
}

function apart(one, other) { return Math.hypot(one[0] - other[0], one[1] - other[1]); }

// What of the map stands still, drawn once, on a canvas that is larger than the map: a frame of a
// map that follows the robot only moves it.
class StillLayer {
  constructor() {
    this.canvas = document.createElement('canvas');
    this.context = this.canvas.getContext('2d');
    this.made = null;  // the centre of what is drawn, and its stamp
  }

  // Put the layer on the map. It is painted anew when its stamp changes, or the map leaves it.
  show(map, stamp, paint) {
    const beyond = Math.round(BEYOND * map.ratio), zoom = map.scale * map.ratio;
    const whole = [stamp, map.scale, map.ratio, map.width, map.height].join();
    const away = () => [(this.made.x - map.center.x) * zoom, (map.center.y - this.made.y) * zoom];
    if (this.made?.whole !== whole || away().some(each => Math.abs(each) > beyond)) {
      this.made = { ...map.center, whole };
      this.paint(map, beyond, zoom, paint);
    }
    const [dx, dy] = away().map(Math.round);
    map.context.setTransform(1, 0, 0, 1, 0, 0);
    map.context.drawImage(this.canvas, dx - beyond, dy - beyond);
  }

  paint(map, beyond, zoom, paint) {
    const { canvas, context: c } = this;
    canvas.width = map.canvas.width + 2 * beyond;
    canvas.height = map.canvas.height + 2 * beyond;
    c.setTransform(zoom, 0, 0, -zoom, canvas.width / 2 - map.center.x * zoom,
                   canvas.height / 2 + map.center.y * zoom);
    c.lineCap = c.lineJoin = 'round';
    const [w, h] = [canvas.width / 2 / zoom, canvas.height / 2 / zoom];
    paint(c, { left: map.center.x - w, right: map.center.x + w,
               low: map.center.y - h, high: map.center.y + h });
  }
}
