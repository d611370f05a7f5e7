// The map: room, track, events, the robot, and how sure the odometry is of its place.

import { fillKey, sign, SIGNS } from './map_signs.js';
import { box, Track } from './map_track.js';

const LEAST_SCALE = 4, MOST_SCALE = 1200, FIRST_SCALE = 90;  // pixels for a metre
const SIGMAS = 2;           // of the ellipse
const EASE = 60;            // ms in which the robot drawn follows the one measured

export class Map2D {
  constructor(canvas, key) {
    this.canvas = canvas;
    this.context = canvas.getContext('2d');
    this.center = { x: 0, y: 0 };
    this.scale = FIRST_SCALE;
    this.follow = true;
    this.onFollow = () => {};
    this.track = new Track();
    this.events = [];
    this.pose = this.drawn = this.truth = this.room = this.origin = null;
    this.radius = 0.165;
    this.lit = {};
    this.pointers = new Map();
    this.dirty = true;
    this.readColors();
    matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => {
      this.readColors();
      fillKey(key, this.color);
    });
    fillKey(key, this.color);
    new ResizeObserver(() => this.resize()).observe(canvas);
    this.listen();
    this.resize();
    requestAnimationFrame(time => this.frame(time));
  }

  readColors() {
    const style = getComputedStyle(document.documentElement);
    this.color = name => style.getPropertyValue(name).trim();
    this.touch();
  }

  touch() { this.dirty = true; }

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

  set(name, value) { this[name] = value; this.touch(); }

  light(group, sides) { this.lit[group] = sides; this.touch(); }

  // Looking.

  listen() {
    const canvas = this.canvas;
    canvas.addEventListener('wheel', event => {
      event.preventDefault();
      this.zoom(Math.exp(-event.deltaY / 400), event.offsetX, event.offsetY);
    }, { passive: false });
    canvas.addEventListener('pointerdown', event => {
      canvas.setPointerCapture(event.pointerId);
      this.pointers.set(event.pointerId, [event.offsetX, event.offsetY]);
    });
    canvas.addEventListener('pointermove', event => this.drag(event));
    for (const end of ['pointerup', 'pointercancel']) {
      canvas.addEventListener(end, event => this.pointers.delete(event.pointerId));
    }
    canvas.addEventListener('dblclick', () => this.setFollow(true));
  }

  drag(event) {
    const before = this.pointers.get(event.pointerId);
    if (!before) return;
    const here = [event.offsetX, event.offsetY];
    if (this.pointers.size === 1) {
      this.setFollow(false);
      this.center.x -= (here[0] - before[0]) / this.scale;
      this.center.y += (here[1] - before[1]) / this.scale;
    } else {
      const other = [...this.pointers].find(([id]) => id !== event.pointerId)[1];
      const apart = point => Math.hypot(point[0] - other[0], point[1] - other[1]) || 1;
      this.zoom(apart(here) / apart(before), (here[0] + other[0]) / 2, (here[1] + other[1]) / 2);
    }
    this.pointers.set(event.pointerId, here);
    this.touch();
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
    this.onFollow(follow);
    this.touch();
  }

  showAll() {
    const corners = this.track.points.map(point => point.slice(0, 2));
    if (this.pose) corners.push([this.pose.x, this.pose.y]);
    if (this.room && this.origin) {
      for (const [ax, ay, bx, by] of this.room.walls) {
        corners.push(this.fromRoom(ax, ay), this.fromRoom(bx, by));
      }
      for (const corner of this.room.grounds.flatMap(pairs)) corners.push(this.fromRoom(...corner));
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
    const zoom = this.scale * ratio;
    c.setTransform(zoom, 0, 0, -zoom, this.canvas.width / 2 - this.center.x * zoom,
                   this.canvas.height / 2 + this.center.y * zoom);
    c.lineCap = c.lineJoin = 'round';
    this.pixel = 1 / this.scale;
    this.drawGrid();
    if (this.room && this.origin) this.drawRoom();
    this.drawTrack();
    if (this.pose) {
      this.drawRobot();
      this.drawEllipse(this.drawn.x, this.drawn.y);
    }
    for (const event of this.events) this.drawSign(event);
    if (this.truth && this.origin) this.drawTruth();
    c.setTransform(ratio, 0, 0, ratio, 0, 0);
    this.drawScale();
  }

  view() {
    const [w, h] = [this.width / 2 / this.scale, this.height / 2 / this.scale];
    return { left: this.center.x - w, right: this.center.x + w,
             low: this.center.y - h, high: this.center.y + h };
  }

  drawGrid() {
    const c = this.context, view = this.view();
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

  drawRoom() {
    const c = this.context, room = this.room;
    c.save();
    c.translate(this.origin[0], this.origin[1]);
    c.rotate(this.origin[2]);
    c.strokeStyle = this.color('--cliff');
    c.fillStyle = this.color('--pit');
    c.lineWidth = 2 * this.pixel;
    c.setLineDash([6 * this.pixel, 5 * this.pixel]);
    for (const polygon of room.cliffs) { this.trace(pairs(polygon)); c.fill(); c.stroke(); }
    for (const polygon of room.grounds) { this.trace(pairs(polygon)); c.stroke(); }
    c.setLineDash([2 * this.pixel, 5 * this.pixel]);
    c.strokeStyle = this.color('--virtual');
    for (const [x, y, yaw, reach] of room.virtual_walls) {
      c.beginPath();
      c.moveTo(x, y);
      c.lineTo(x + reach * Math.cos(yaw), y + reach * Math.sin(yaw));
      c.stroke();
    }
    c.setLineDash([]);
    c.strokeStyle = this.color('--room');
    c.fillStyle = this.color('--room');
    c.lineWidth = Math.max(0.03, 2 * this.pixel);
    c.beginPath();
    for (const [ax, ay, bx, by] of room.walls) { c.moveTo(ax, ay); c.lineTo(bx, by); }
    c.stroke();
    for (const [x, y, radius] of room.posts) {
      c.beginPath(); c.arc(x, y, radius, 0, 7); c.fill();
    }
    for (const pose of room.home_bases) this.drawHomeBase(...pose);
    c.restore();
  }

  trace(points) {
    this.context.beginPath();
    points.forEach(([x, y], at) => this.context[at ? 'lineTo' : 'moveTo'](x, y));
    this.context.closePath();
  }

  drawHomeBase(x, y, yaw) {
    const c = this.context;
    c.save();
    c.translate(x, y);
    c.rotate(yaw);
    c.fillStyle = this.color('--accent');
    c.fillRect(-0.03, -0.1, 0.06, 0.2);
    c.restore();
  }

  drawTruth() {
    const c = this.context, turn = this.origin[2], yaw = this.truth[2] + turn;
    const [x, y] = this.fromRoom(this.truth[0], this.truth[1]);
    c.strokeStyle = this.color('--truth');
    c.lineWidth = 2 * this.pixel;
    c.setLineDash([4 * this.pixel, 4 * this.pixel]);
    c.beginPath();
    c.arc(x, y, this.radius, 0, 7);
    c.moveTo(x, y);
    c.lineTo(x + this.radius * Math.cos(yaw), y + this.radius * Math.sin(yaw));
    c.stroke();
    c.setLineDash([]);
  }

  drawTrack() {
    const c = this.context, view = this.view();
    c.strokeStyle = this.color('--track');
    c.lineWidth = 2.5 * this.pixel;
    this.track.draw(c, view, this.drawn);
  }

  drawSign([kind, x, y]) {
    const c = this.context;
    c.save();
    c.translate(x, y);
    c.scale(this.pixel, -this.pixel);
    sign(c, kind, this.color(SIGNS[kind][1]), this.color('--card'));
    c.restore();
  }

  drawRobot() {
    const c = this.context, { x, y, yaw } = this.drawn, radius = this.radius;
    c.save();
    c.translate(x, y);
    c.rotate(yaw);
    c.lineWidth = 2 * this.pixel;
    c.fillStyle = this.color('--robot');
    c.strokeStyle = this.color('--ink');
    c.beginPath();
    c.arc(0, 0, radius, 0, 7);
    c.fill();
    c.stroke();
    const bump = this.lit.bump || {};
    for (const [on, from, to] of [[bump.left, 0, Math.PI / 2], [bump.right, -Math.PI / 2, 0]]) {
      if (!on) continue;
      c.strokeStyle = this.color('--bump');
      c.lineWidth = Math.max(0.035, 5 * this.pixel);
      c.beginPath();
      c.arc(0, 0, radius, from, to);
      c.stroke();
    }
    const small = Math.max(radius, 9 * this.pixel);  // an arrow that is seen from afar
    c.fillStyle = this.color('--ink');
    c.beginPath();
    c.moveTo(0.8 * small, 0);
    c.lineTo(-0.45 * small, 0.45 * small);
    c.lineTo(-0.2 * small, 0);
    c.lineTo(-0.45 * small, -0.45 * small);
    c.closePath();
    c.fill();
    c.restore();
  }

  drawEllipse(x, y) {
    const [xx, xy, yy] = this.pose.covariance;
    if ([xx, xy, yy].some(each => each === null)) return;
    const middle = (xx + yy) / 2;
    const apart = Math.hypot((xx - yy) / 2, xy);
    const [long, short] = [middle + apart, Math.max(0, middle - apart)]
      .map(variance => SIGMAS * Math.sqrt(variance));
    const c = this.context;
    c.fillStyle = this.color('--doubt');
    c.strokeStyle = this.color('--doubt-edge');
    c.lineWidth = 1.5 * this.pixel;
    c.beginPath();
    c.ellipse(x, y, long, short, Math.atan2(2 * xy, xx - yy) / 2, 0, 7);
    c.fill();
    c.stroke();
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

function pairs(flat) {
  return Array.from({ length: flat.length / 2 }, (_, at) => [flat[2 * at], flat[2 * at + 1]]);
}
