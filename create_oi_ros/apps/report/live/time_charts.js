// Copyright 2026 create_oi_ros contributors
// SPDX-License-Identifier: Apache-2.0
// Charts that share one time: they zoom together, and one cursor shows the values in all of them.

import { indexAt, countBetween, perPixel } from './curves.js';
import { drawSpans, valueOfSpans } from './span_rows.js';

const LEFT = 52, RIGHT = 6;     // pixels beside the curves
const SHORTEST = 0.2;           // seconds that are shown at least
const DASHES = [[], [6, 3], [2, 3]];
const COLORS = ['--line-1', '--line-2', '--line-3'];
const TICKS = [0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 15, 30, 60, 120, 300, 600, 900, 1800, 3600];

export class TimeCharts {
  constructor(place, charts, seconds, gaps, color, onTime) {
    Object.assign(this, { seconds, gaps, color, onTime });
    this.from = 0;
    this.to = seconds;
    this.time = 0;
    this.look = 0;  // grows when the colours change
    this.pointers = new Map();
    this.keys = [];  // of the lines, in the captions: a canvas, and which line
    this.charts = charts.map(chart => this.build(place, chart));
    this.due = false;
    new ResizeObserver(() => this.touch()).observe(place);
    this.touch();
  }

  build(place, chart) {
    const figure = document.createElement('figure'), caption = document.createElement('figcaption');
    const values = document.createElement('span'), paper = document.createElement('div');
    const canvas = document.createElement('canvas');
    canvas.tabIndex = 0;
    canvas.setAttribute('role', 'img');
    canvas.setAttribute('aria-label', `Chart: ${chart.title}`);
    values.className = 'chart-values';
    paper.className = chart.rows ? 'paper rows-of-spans' : 'paper';
    paper.append(canvas);
    caption.append(chart.title, values);
    figure.append(caption, paper);
    place.append(figure);
    this.listen(canvas);
    const keys = (chart.lines || [{ name: '' }]).map(({ name }, at) => {
      const item = document.createElement('span'), text = document.createElement('b');
      if (name) item.append(this.key(at), `${name} `);
      item.append(text);
      values.append(item);
      return text;
    });
    return { ...chart, canvas, still: document.createElement('canvas'), stamp: '', keys };
  }

  key(at) {
    const canvas = document.createElement('canvas');
    canvas.className = 'chart-key';
    this.keys.push([canvas, at]);
    this.drawKey(canvas, at);
    return canvas;
  }

  drawKey(canvas, at) {
    const ratio = devicePixelRatio || 1, c = canvas.getContext('2d');
    canvas.width = 16 * ratio; canvas.height = 8 * ratio;  // clears it, too
    c.scale(ratio, ratio);
    this.pen(c, at);
    c.beginPath(); c.moveTo(0, 4); c.lineTo(16, 4); c.stroke();
  }

  pen(c, at) {
    c.strokeStyle = this.color(COLORS[at]);
    c.lineWidth = 1.6;
    c.setLineDash(DASHES[at]);
  }

  // Looking.

  listen(canvas) {
    canvas.addEventListener('wheel', event => {
      event.preventDefault();
      const wide = (this.to - this.from) / (canvas.clientWidth - LEFT - RIGHT);
      if (Math.abs(event.deltaX) > Math.abs(event.deltaY)) this.show(this.from + event.deltaX * wide);
      else this.zoom(Math.exp(event.deltaY / 400), this.timeOf(canvas, event.offsetX));
    }, { passive: false });
    canvas.addEventListener('pointerdown', event => {
      canvas.setPointerCapture(event.pointerId);
      this.pointers.set(event.pointerId, event.offsetX);
      if (this.pointers.size === 1 && !event.shiftKey) this.onTime(this.timeOf(canvas, event.offsetX));
    });
    canvas.addEventListener('pointermove', event => this.drag(canvas, event));
    for (const end of ['pointerup', 'pointercancel']) {
      canvas.addEventListener(end, event => this.pointers.delete(event.pointerId));
    }
  }

  drag(canvas, event) {
    const before = this.pointers.get(event.pointerId), here = event.offsetX;
    if (before === undefined) return;
    const perPixelTime = (this.to - this.from) / (canvas.clientWidth - LEFT - RIGHT);
    if (this.pointers.size > 1) {
      const [, other] = [...this.pointers].find(([id]) => id !== event.pointerId);
      const factor = Math.max(1, Math.abs(before - other)) / Math.max(1, Math.abs(here - other));
      this.zoom(factor, this.timeOf(canvas, (here + other) / 2));
    } else if (event.shiftKey) this.show(this.from - (here - before) * perPixelTime);
    else this.onTime(this.timeOf(canvas, here));
    this.pointers.set(event.pointerId, here);
  }

  timeOf(canvas, px) {
    const part = (px - LEFT) / (canvas.clientWidth - LEFT - RIGHT);
    return Math.min(this.seconds, Math.max(0, this.from + part * (this.to - this.from)));
  }

  zoom(factor, around = this.time) {
    const long = Math.min(this.seconds, Math.max(Math.min(SHORTEST, this.seconds),
                                                 (this.to - this.from) * factor));
    const part = (around - this.from) / (this.to - this.from || 1);
    this.show(around - part * long, long);
  }

  show(from, long = this.to - this.from) {
    this.from = Math.max(0, Math.min(this.seconds - long, from));
    this.to = this.from + long;
    this.touch();
  }

  // Move the cursor; what is shown follows it.
  setTime(time) {
    this.time = time;
    if (time < this.from || time > this.to) this.show(time - (this.to - this.from) / 2);
    this.touch();
  }

  recolor() {
    this.look += 1;
    for (const [canvas, at] of this.keys) this.drawKey(canvas, at);
    this.touch();
  }

  // Drawing, once a frame.

  touch() {
    if (this.due) return;
    this.due = true;
    requestAnimationFrame(() => {
      this.due = false;
      for (const chart of this.charts) this.draw(chart);
    });
  }

  // What stands still while the cursor moves is kept on a canvas of its own.
  draw(chart) {
    const { canvas, still } = chart;
    const ratio = devicePixelRatio || 1, width = canvas.clientWidth, height = canvas.clientHeight;
    if (!width) return;
    const stamp = [width, height, ratio, this.from, this.to, this.look].join();
    if (chart.stamp !== stamp) {
      chart.stamp = stamp;
      for (const each of [canvas, still]) {
        each.width = Math.round(width * ratio); each.height = Math.round(height * ratio);
      }
      this.paint(chart, still.getContext('2d'), ratio, width, height);
    }
    const c = canvas.getContext('2d');
    c.setTransform(1, 0, 0, 1, 0, 0);
    c.clearRect(0, 0, canvas.width, canvas.height);
    c.drawImage(still, 0, 0);
    c.setTransform(ratio, 0, 0, ratio, 0, 0);
    this.drawCursor(c, this.place(width), height);
    chart.keys.forEach((text, at) => { text.textContent = this.valueAt(chart, at); });
  }

  place(width) {
    const wide = width - LEFT - RIGHT;
    return time => LEFT + (time - this.from) / (this.to - this.from || 1) * wide;
  }

  paint(chart, c, ratio, width, height) {
    c.scale(ratio, ratio);
    const paper = { c, px: this.place(width), wide: width - LEFT - RIGHT, height, left: LEFT,
                    color: this.color, from: this.from, to: this.to };
    this.drawGaps(paper);
    this.drawTimes(paper);
    if (chart.rows) drawSpans(paper, chart.rows);
    else this.drawLines(paper, chart);
  }

  drawGaps({ c, px, height }) {
    c.fillStyle = this.color('--gap');
    for (const [start, end] of this.gaps) {
      const from = Math.max(px(start), LEFT), to = Math.max(px(end), LEFT);
      c.fillRect(from, 0, Math.max(to - from, to > LEFT ? 1 : 0), height);
    }
  }

  drawTimes({ c, px, wide, height }) {
    const least = (this.to - this.from) / Math.max(1, wide / 70);
    const step = TICKS.find(each => each >= least) || 7200;
    c.strokeStyle = this.color('--grid');
    c.fillStyle = this.color('--faint');
    c.font = '10px system-ui, sans-serif';
    c.textBaseline = 'bottom';
    c.lineWidth = 1;
    for (let tick = Math.ceil(this.from / step) * step; tick <= this.to; tick += step) {
      c.beginPath(); c.moveTo(px(tick), 0); c.lineTo(px(tick), height); c.stroke();
      const text = clock(tick).replace(/\.0$/, '');
      if (px(tick) + c.measureText(text).width + 3 < LEFT + wide) c.fillText(text, px(tick) + 3, height);
    }
  }

  drawLines({ c, px, wide, height }, { lines, least, digits }) {
    const shown = lines.map(line => this.visible(line, Math.max(1, Math.round(wide))));
    let [low, high] = least;
    for (const each of shown) { low = Math.min(low, each.low); high = Math.max(high, each.high); }
    const py = value => 7 + (high - value) / (high - low) * (height - 23);
    this.drawScale(c, py, low, high, digits, wide);
    c.save();
    c.beginPath(); c.rect(LEFT, 0, wide, height); c.clip();
    shown.forEach((each, at) => each.draw(c, px, py, at));
    c.restore();
  }

  drawScale(c, py, low, high, digits, wide) {
    c.strokeStyle = this.color('--grid');
    c.fillStyle = this.color('--faint');
    c.textAlign = 'right';
    c.textBaseline = 'middle';
    for (const value of new Set([low, high, low < 0 && high > 0 ? 0 : low])) {
      c.beginPath(); c.moveTo(LEFT, py(value)); c.lineTo(LEFT + wide, py(value)); c.stroke();
      c.fillText(value.toFixed(value === 0 ? 0 : digits), LEFT - 4, py(value));
    }
    c.textAlign = 'left';
  }

  // Return the part of a line that is shown: every point if there are few, else what pixels show.
  visible({ times, values, step, hold }, columns) {
    const first = Math.max(0, indexAt(times, this.from));
    if (countBetween(times, this.from, this.to) > 2 * columns) {
      const pixels = perPixel(times, values, this.from, this.to, columns);
      return { low: least(pixels.map(each => each.low)), high: most(pixels.map(each => each.high)),
               draw: (c, px, py, at) => this.drawPixels(c, py, pixels, columns, at) };
    }
    const last = Math.min(times.length - 1, indexAt(times, this.to) + 1);
    const seen = Array.from(values.subarray(first, last + 1)).filter(Number.isFinite);
    return { low: least(seen), high: most(seen), draw: (c, px, py, at) => {
      this.pen(c, at);
      c.beginPath();
      for (let place = first; place <= last; place += 1) {
        const gone = place === first || times[place] - times[place - 1] > hold
          || Number.isNaN(values[place - 1]);
        if (Number.isNaN(values[place])) continue;
        if (step && !gone) c.lineTo(px(times[place]), py(values[place - 1]));
        c[gone ? 'moveTo' : 'lineTo'](px(times[place]), py(values[place]));
      }
      c.stroke();
      c.setLineDash([]);
    } };
  }

  // From least to greatest pale, the mean strong.
  drawPixels(c, py, pixels, columns, at) {
    c.globalAlpha = 0.3;
    c.fillStyle = this.color(COLORS[at]);
    for (const { column, low, high } of pixels) {
      c.fillRect(LEFT + column, py(high), 1, Math.max(1, py(low) - py(high)));
    }
    c.globalAlpha = 1;
    this.pen(c, at);
    c.beginPath();
    let before = -9;
    for (const { column, mean } of pixels) {
      c[column - before > 3 ? 'moveTo' : 'lineTo'](LEFT + column + 0.5, py(mean));
      before = column;
    }
    c.stroke();
    c.setLineDash([]);
  }

  drawCursor(c, px, height) {
    c.strokeStyle = this.color('--ink');
    c.lineWidth = 1;
    c.beginPath(); c.moveTo(px(this.time), 0); c.lineTo(px(this.time), height); c.stroke();
  }

  valueAt(chart, at) {
    if (chart.rows) return valueOfSpans(chart.rows, this.time);
    const { times, values, hold } = chart.lines[at];
    const place = indexAt(times, this.time);
    if (place < 0 || this.time - times[place] > hold || Number.isNaN(values[place])) return '–';
    return `${values[place].toFixed(chart.digits)}${chart.unit ? ` ${chart.unit}` : ''}`;
  }
}

const least = values => values.reduce((a, b) => Math.min(a, b), Infinity);
const most = values => values.reduce((a, b) => Math.max(a, b), -Infinity);

export function clock(seconds) {
  const tenths = Math.round(seconds * 10) / 10;
  const hours = Math.floor(tenths / 3600), minutes = Math.floor(tenths / 60) % 60;
  const rest = (tenths % 60).toFixed(1).padStart(4, '0');
  return hours ? `${hours}:${String(minutes).padStart(2, '0')}:${rest}` : `${minutes}:${rest}`;
}
