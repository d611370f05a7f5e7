// Copyright 2026 create_oi_ros contributors
// SPDX-License-Identifier: Apache-2.0
// The map: room, track, events, the robot, and how sure the odometry is of its place.

import { element } from './dom.js';
import {
  cornersOf, crosses, drawEllipse, drawRing, drawRobot, drawRoom, drawSign, fillKey, Pen,
} from './map_drawing.js';
import { Track } from './map_track.js';

const LEAST_SCALE = 4, MOST_SCALE = 1200, FIRST_SCALE = 90;  // pixels for a metre
const BEYOND = 400;         // pixels by which what stands still is wider than the map
const BUTTONS = 90;         // pixels that they hide on the right
const MARGIN = 0.6;         // metres, around everything
const ZOOM = 1.35;          // of one step
const TAP = 6;              // pixels that a finger may move while it taps
const EASE = 60;            // ms in which the robot drawn follows the one measured
const JUMP = 0.5;           // metres, farther than which it does not drive there
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
    this.still = document.createElement('canvas');
    this.stamp = '';            // of what is drawn on it
    this.changes = 0;           // of what stands still, besides the track
    this.events = [];
    this.pose = this.drawn = this.truth = this.room = this.origin = null;
    this.way = [];              // where goals lead: x, y, and a heading or null where they end
    this.radius = 0.165;
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
    const place = element(this.canvas.parentElement, 'div', { className: 'map-buttons' });
    const button = (id, textContent, title, onclick) =>
      element(place, 'button', { id, textContent, title, onclick });
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
    const corners = [...this.track.points];
    if (this.pose) corners.push([this.pose.x, this.pose.y]);
    if (this.room && this.origin) {
      corners.push(...cornersOf(this.room).map(corner => this.fromRoom(...corner)));
    }
    if (!corners.length) return;
    const [xs, ys] = [0, 1].map(axis => corners.map(each => each[axis]));
    const [left, right] = [Math.min(...xs), Math.max(...xs)];
    const [low, high] = [Math.min(...ys), Math.max(...ys)];
    this.setFollow(false);
    const fits = Math.min((this.width - BUTTONS) / (right - left + MARGIN),
                          this.height / (high - low + MARGIN));
    this.scale = Math.max(LEAST_SCALE, Math.min(FIRST_SCALE * 2, fits));
    this.center = { x: (left + right + BUTTONS / this.scale) / 2, y: (low + high) / 2 };
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
    const turn = Math.atan2(Math.sin(pose.yaw - drawn.yaw), Math.cos(pose.yaw - drawn.yaw));
    const away = Math.hypot(pose.x - drawn.x, pose.y - drawn.y);
    if (away < 2e-4 && Math.abs(turn) < 1e-3) return false;
    const part = away > JUMP ? 1 : 1 - Math.exp(-elapsed / EASE);
    drawn.x += (pose.x - drawn.x) * part;
    drawn.y += (pose.y - drawn.y) * part;
    drawn.yaw += turn * part;
    return true;
  }

  draw() {
    this.dirty = false;
    const { drawn, radius } = this;
    if (!this.width) return;
    if (this.follow && drawn) this.center = { x: drawn.x, y: drawn.y };
    const pen = this.penOn(this.canvas, this.center, () => this.showStill()), { c } = pen;
    this.track.drawNew(pen, drawn);
    this.drawWay(pen);
    if (this.pose) {
      drawRobot(pen, drawn, radius, this.bump);
      if (this.pose.covariance) drawEllipse(pen, drawn, this.pose.covariance);
    }
    for (const [name, x, y] of this.events) {
      pen.at([x, y, 0], () => {
        c.scale(pen.pixel, -pen.pixel);
        drawSign(new Pen(c, this.color), name);
      });
    }
    if (this.truth && this.origin) {
      const [x, y, yaw] = this.truth;
      drawRing(pen, [...this.fromRoom(x, y), yaw + this.origin[2]], radius, '--truth');
    }
    c.setTransform(this.ratio, 0, 0, this.ratio, 0, 0);
    this.drawScale(new Pen(c, this.color));
  }

  // Return a pen for metres on a canvas that is empty but for a background.
  penOn(canvas, { x, y }, background = () => {}) {
    const c = canvas.getContext('2d'), zoom = this.scale * this.ratio;
    c.setTransform(1, 0, 0, 1, 0, 0);
    c.clearRect(0, 0, canvas.width, canvas.height);
    background();
    c.setTransform(zoom, 0, 0, -zoom, canvas.width / 2 - x * zoom, canvas.height / 2 + y * zoom);
    c.lineCap = c.lineJoin = 'round';
    return new Pen(c, this.color, 1 / this.scale);
  }

  // Show what stands still. It is drawn once, on a larger canvas around a place near the middle: a
  // long track takes 50 ms, so a frame of a map that follows the robot only moves it.
  showStill() {
    const { canvas, still, center, ratio } = this, zoom = this.scale * ratio;
    const cell = BEYOND / this.scale;
    const [x, y] = [center.x, center.y].map(each => Math.round(each / cell) * cell);
    const stamp = [x, y, this.changes, this.track.still, zoom, canvas.width, canvas.height].join();
    if (this.stamp !== stamp) {
      this.stamp = stamp;
      still.width = canvas.width + BEYOND * ratio;
      still.height = canvas.height + BEYOND * ratio;
      const pen = this.penOn(still, { x, y });
      this.drawGrid(pen, x, y);
      if (this.room && this.origin) drawRoom(pen, this.room, this.origin);
      this.track.drawStill(pen);
    }
    this.context.drawImage(still, Math.round((x - center.x) * zoom - BEYOND * ratio / 2),
                           Math.round((center.y - y) * zoom - BEYOND * ratio / 2));
  }

  drawGrid(pen, x, y) {
    const step = this.scale > 30 ? 1 : this.scale > 8 ? 5 : 20;
    const [wide, high] = [this.width, this.height].map(each => (each + BEYOND) / 2 / this.scale);
    pen.draw(c => {
      for (let at = Math.ceil((x - wide) / step) * step; at <= x + wide; at += step) {
        c.moveTo(at, y - high); c.lineTo(at, y + high);
      }
      for (let at = Math.ceil((y - high) / step) * step; at <= y + high; at += step) {
        c.moveTo(x - wide, at); c.lineTo(x + wide, at);
      }
    }, { stroke: '--grid', width: 1 });
  }

  // A way from the robot to one place after the other, as pairs of places.
  legs(way) {
    return this.pose ? way.map((to, at) => [way[at - 1] || [this.pose.x, this.pose.y], to]) : [];
  }

  blocks([from, to]) {
    return Boolean(this.room && this.origin) && crosses(this.room, this.origin, from, to, NARROW * this.radius);
  }

  isBlocked(way) { return this.legs(way).some(leg => this.blocks(leg)); }

  drawWay(pen) {
    for (const leg of this.legs(this.way)) {
      const [from, to] = leg, blocked = this.blocks(leg);
      pen.draw(c => { c.moveTo(from[0], from[1]); c.lineTo(to[0], to[1]); },
               blocked ? { stroke: '--stop', width: 4 } : { stroke: '--accent' });
      if (to.length > 2) drawRing(pen, to, this.radius, '--accent');
    }
  }

  drawScale(pen) {
    const metres = [0.1, 0.2, 0.5, 1, 2, 5, 10, 20].find(each => each * this.scale >= 50) || 50;
    const right = 14 + metres * this.scale, low = this.height - 14;
    pen.draw(c => {
      c.moveTo(14, low - 5); c.lineTo(14, low); c.lineTo(right, low); c.lineTo(right, low - 5);
    }, { stroke: '--ink', width: 1.5 });
    pen.c.font = '12px system-ui, sans-serif';
    pen.c.fillStyle = this.color('--ink');
    pen.c.fillText(`${metres} m`, 18, low - 5);
  }
}

function apart(one, other) { return Math.hypot(one[0] - other[0], one[1] - other[1]); }
