// Copyright 2026 create_oi_ros contributors
// SPDX-License-Identifier: Apache-2.0
// Charts that share one time: curves, and bars of what held. They zoom together, and one cursor
// shows the values in all of them. The report gives them a recording, the live page its last minute.

import { element } from './dom.js';

const RIGHT = 6, LEFT = 52, NARROW_LEFT = 34, NARROW = 260;  // pixels: beside the curves; a chart
const SHORTEST = 0.2;           // seconds that are shown at least
const CLICK = 5;                // pixels that the pointer may move in a click
const DASHES = [[], [6, 3], [2, 3], [9, 3, 2, 3]];
const COLORS = ['--line-1', '--line-2', '--line-3', '--line-4'];
const TICKS = [0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 15, 30, 60, 120, 300, 600, 900, 1800, 3600];
const TINTS = {
  mode: '--accent', bumper: '--bump', cliff: '--cliff', 'wheel drop': '--drop',
  overcurrent: '--error', buttons: '--faint', song: '--good', charging: '--line-1',
};
const HALF = 'mode';            // its bars lie beside each other: they are outlined, with their names

export class Charts {
  // A chart is { title, digits, least: [low, high], lines: [{ name, times, values, hold, step }] }
  // or { title, rows: [{ name, spans: [[start, end, text], ...] }] }. A line is not drawn over more
  // than `hold` seconds without a value. Optional, and to be set later too: `gaps`, pairs of times;
  // `onTime(time)`, a click; `onHover(time or null)`; `onLooking()`, another part is shown;
  // `text(time)`, the name of a time, and `zero`, the time of a tick.
  constructor(place, charts, color, options) {
    Object.assign(this, { color, first: 0, last: 0, gaps: [], zero: 0, text: String,
                          onTime: time => this.peek(time), onHover: () => {}, onLooking: () => {}, ...options });
    this.from = this.first;
    this.to = this.last;
    this.time = this.hover = null;  // the cursor; a pointer over a chart goes before it
    this.selection = null;          // two times between which a drag will zoom
    this.look = 0;                  // grows when what stands still has to be drawn anew
    this.pointers = new Map();
    this.due = false;
    this.choice = place.parentElement.querySelector('.chart-choice div');
    this.charts = charts.map(chart => this.build(place, chart));
    new ResizeObserver(() => this.touch()).observe(place);
    matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => this.redraw());
  }

  build(place, chart) {
    const figure = element(place, 'figure'), caption = element(figure, 'figcaption');
    element(caption, 'span', { textContent: chart.title });
    const values = element(caption, 'span', { className: 'chart-values' });
    const paper = element(figure, 'div', { className: 'paper' });
    const canvas = element(paper, 'canvas', { role: 'img', ariaLabel: `Chart: ${chart.title}` });
    if (chart.rows) paper.style.height = `${1.2 * chart.rows.length + 1}rem`;
    const lines = (chart.lines || [{ name: '' }]).map((line, at) => {
      const item = element(values, 'span');
      if (line.name) element(item, 'span', { className: 'chart-key' }).dataset.line = at;
      if (line.name) item.append(`${line.name} `);
      return { ...line, at, item, shown: true, value: element(item, 'b') };
    });
    const built = { ...chart, figure, canvas, still: document.createElement('canvas'), stamp: '', lines };
    for (const line of lines) this.offer(built, line);
    this.listen(canvas);
    return built;
  }

  // A check box that shows and hides a line, and its chart with the last one.
  offer(chart, line) {
    const label = element(this.choice, 'label', { className: 'check' });
    const box = element(label, 'input', { type: 'checkbox', checked: true });
    label.append(line.name ? `${chart.title}: ${line.name}` : chart.title);
    box.addEventListener('change', () => {
      line.shown = box.checked;
      line.item.hidden = !box.checked;
      chart.figure.hidden = !chart.lines.some(each => each.shown);
      this.redraw();
    });
  }

  // Looking.

  listen(canvas) {
    canvas.addEventListener('wheel', event => {
      const along = Math.abs(event.deltaX) > Math.abs(event.deltaY);
      if (!along && !event.ctrlKey && !event.metaKey) return;  // the wheel scrolls the page
      event.preventDefault();
      if (along) this.show(this.from + event.deltaX * this.perPixel(canvas));
      else this.zoom(Math.exp(event.deltaY / 400), this.timeOf(canvas, event.offsetX));
    }, { passive: false });
    canvas.addEventListener('pointerdown', event => {
      if (event.button) return;
      canvas.setPointerCapture(event.pointerId);
      this.pointers.set(event.pointerId, { here: event.offsetX, began: event.offsetX, click: true });
      if (event.pointerType !== 'mouse' && this.pointers.size === 1) this.choose(canvas, event);
    });
    canvas.addEventListener('pointermove', event => this.move(canvas, event));
    canvas.addEventListener('pointerup', event => this.release(canvas, event));
    canvas.addEventListener('pointercancel', event => {
      this.pointers.delete(event.pointerId);
      this.selection = null;
    });
    canvas.addEventListener('pointerleave', () => this.peek(null));
    canvas.addEventListener('dblclick', () => this.show(this.first, this.last - this.first));
  }

  // A mouse that is held selects what to zoom to; a finger moves the cursor, two fingers zoom.
  move(canvas, event) {
    const held = this.pointers.get(event.pointerId), here = event.offsetX;
    if (!held) { this.peek(this.timeOf(canvas, here)); return; }
    if (Math.abs(here - held.began) > CLICK) held.click = false;
    if (this.pointers.size > 1) {
      const [, other] = [...this.pointers].find(([id]) => id !== event.pointerId);
      const apart = px => Math.max(1, Math.abs(px - other.here));
      this.zoom(apart(held.here) / apart(here), this.timeOf(canvas, (here + other.here) / 2));
    } else if (event.pointerType !== 'mouse') this.choose(canvas, event);
    else if (event.shiftKey) this.show(this.from - (here - held.here) * this.perPixel(canvas));
    else if (!held.click) {
      this.selection = [held.began, here].map(px => this.timeOf(canvas, px)).sort((a, b) => a - b);
      this.touch();
    }
    held.here = here;
  }

  release(canvas, event) {
    const held = this.pointers.get(event.pointerId), selected = this.selection;
    this.pointers.delete(event.pointerId);
    this.selection = null;
    if (selected) this.show(selected[0], Math.max(SHORTEST, selected[1] - selected[0]));
    else if (held?.click && !event.shiftKey) this.choose(canvas, event);
  }

  choose(canvas, event) {
    this.onTime(this.timeOf(canvas, event.offsetX));
  }

  peek(time) {
    this.hover = time;
    this.onHover(time);
    this.touch();
  }

  zoom(factor, around = this.time ?? this.to) {
    const whole = this.last - this.first, long = this.to - this.from;
    const wanted = Math.min(whole, Math.max(Math.min(SHORTEST, whole), long * factor));
    this.show(around - (around - this.from) / (long || 1) * wanted, wanted);
  }

  // Show a period; the cursor moves with it where it would leave it.
  show(from, long = this.to - this.from) {
    this.from = Math.max(this.first, Math.min(this.last - long, from));
    this.to = this.from + long;
    this.onLooking();
    if (this.time !== null && (this.time < this.from || this.time > this.to)) {
      this.onTime(Math.min(this.to, Math.max(this.from, this.time)));
    }
    this.touch();
  }

  // Move the cursor; what is shown follows it.
  setTime(time) {
    this.time = time;
    if (time < this.from || time > this.to) this.show(time - (this.to - this.from) / 2);
    this.touch();
  }

  // Values have come, from `first` to `last`; show the newest `long` seconds, unless it is 0.
  extend(first, last, long) {
    Object.assign(this, { first, last });
    if (long) Object.assign(this, { from: last - long, to: last, zero: last });
    this.redraw();
  }

  perPixel(canvas) { return (this.to - this.from) / wideOf(canvas); }

  timeOf(canvas, px) {
    const time = this.from + (px - leftOf(canvas)) * this.perPixel(canvas);
    return Math.min(this.to, Math.max(this.from, time));
  }

  // Drawing, once a frame.

  redraw() {
    this.look += 1;
    this.touch();
  }

  touch() {
    if (this.due) return;
    this.due = true;
    requestAnimationFrame(() => {
      this.due = false;
      for (const chart of this.charts) if (!chart.figure.hidden) this.draw(chart);
    });
  }

  // What stands still while the cursor moves is kept on a canvas of its own.
  draw(chart) {
    const { canvas, still } = chart, ratio = devicePixelRatio || 1;
    const width = canvas.clientWidth, height = canvas.clientHeight;
    if (!width) return;
    const stamp = [width, height, ratio, this.from, this.to, this.look].join();
    if (chart.stamp !== stamp) {
      chart.stamp = stamp;
      for (const each of [canvas, still]) {
        each.width = Math.round(width * ratio); each.height = Math.round(height * ratio);
      }
      this.paint(chart, still.getContext('2d'), ratio);
    }
    const c = canvas.getContext('2d'), px = this.place(canvas), time = this.hover ?? this.time;
    c.setTransform(1, 0, 0, 1, 0, 0);
    c.clearRect(0, 0, canvas.width, canvas.height);
    c.drawImage(still, 0, 0);
    c.setTransform(ratio, 0, 0, ratio, 0, 0);
    c.fillStyle = this.color('--accent');
    c.globalAlpha = 0.2;
    const [start, end] = (this.selection || [0, 0]).map(px);
    c.fillRect(start, 0, end - start, height);
    c.globalAlpha = 1;
    c.fillStyle = this.color('--ink');
    if (time !== null) c.fillRect(px(time) - 0.5, 0, 1, height);
    for (const line of chart.lines) line.value.textContent = this.valueAt(chart, line, time ?? this.to);
  }

  place(canvas) {
    const left = leftOf(canvas), scale = wideOf(canvas) / (this.to - this.from || 1);
    return time => left + (time - this.from) * scale;
  }

  paint(chart, c, ratio) {
    const { canvas } = chart, px = this.place(canvas), height = canvas.clientHeight;
    const left = leftOf(canvas), wide = wideOf(canvas);
    c.scale(ratio, ratio);
    c.font = '10px system-ui, sans-serif';
    c.lineWidth = 1;
    const within = draw => {
      c.save();
      c.beginPath(); c.rect(left, 0, wide, height); c.clip();
      draw();
      c.restore();
    };
    c.fillStyle = this.color('--gap');
    within(() => this.gaps.forEach(([start, end]) => {
      c.fillRect(px(start), 0, Math.max(px(end) - px(start), 1), height);
    }));
    const paper = { c, px, left, wide, height, within };
    this.drawTimes(paper);
    if (chart.rows) this.drawSpans(paper, chart.rows);
    else this.drawLines(paper, chart);
  }

  drawTimes({ c, px, left, wide, height }) {
    const least = (this.to - this.from) / Math.max(1, wide / 70);
    const step = TICKS.find(each => each >= least) || 7200;
    c.strokeStyle = this.color('--grid');
    c.fillStyle = this.color('--faint');
    c.textBaseline = 'bottom';
    for (let at = Math.ceil((this.from - this.zero) / step); at * step + this.zero <= this.to; at += 1) {
      const x = px(at * step + this.zero), text = this.text(at * step + this.zero).replace(/\.0$/, '');
      c.beginPath(); c.moveTo(x, 0); c.lineTo(x, height); c.stroke();
      if (x + c.measureText(text).width + 3 < left + wide) c.fillText(text, x + 3, height);
    }
  }

  drawLines({ c, left, wide, height, within }, { lines, least, digits }) {
    const shown = lines.filter(line => line.shown).map(line => [line, this.pixels(line, wide)]);
    const pixels = shown.flatMap(([, each]) => each);
    const low = Math.min(least[0], ...pixels.map(each => each.low));
    const high = Math.max(least[1], ...pixels.map(each => each.high));
    const py = value => 7 + (high - value) / (high - low) * (height - 23);
    c.textAlign = 'right';
    c.textBaseline = 'middle';
    for (const value of new Set([low, high, low < 0 && high > 0 ? 0 : low])) {
      c.beginPath(); c.moveTo(left, py(value)); c.lineTo(left + wide, py(value)); c.stroke();
      if (value && Math.abs(py(value) - py(0)) < 9) continue;  // it would lie over the 0
      c.fillText(value.toFixed(value === 0 ? 0 : digits), left - 4, py(value));
    }
    within(() => shown.forEach(([line, each]) => this.drawLine(c, py, left, line, each)));
  }

  // The part of a line that is shown: of each pixel that has values the least, the greatest, the
  // mean, the last, and the times of the first and the last.
  pixels({ times, values }, wide) {
    const found = [], scale = wide / (this.to - this.from || 1);
    const last = Math.min(times.length - 1, indexAt(times, this.to) + 1);
    for (let at = Math.max(0, indexAt(times, this.from)); at <= last; at += 1) {
      const value = values[at], column = Math.floor((times[at] - this.from) * scale);
      if (Number.isNaN(value)) continue;
      if (found.at(-1)?.column !== column) {
        found.push({ column, begin: times[at], low: value, high: value, sum: 0, count: 0 });
      }
      const pixel = found.at(-1);
      pixel.low = Math.min(pixel.low, value);
      pixel.high = Math.max(pixel.high, value);
      pixel.sum += value;
      pixel.count += 1;
      pixel.last = value;
      pixel.end = times[at];
    }
    return found;
  }

  // From least to greatest pale, the mean strong.
  drawLine(c, py, left, { at, step, hold }, pixels) {
    c.globalAlpha = 0.3;
    c.fillStyle = this.color(COLORS[at]);
    for (const { column, low, high } of pixels) {
      if (low < high) c.fillRect(left + column, py(high), 1, py(low) - py(high));
    }
    c.globalAlpha = 1;
    c.strokeStyle = this.color(COLORS[at]);
    c.lineWidth = 1.6;
    c.setLineDash(DASHES[at]);
    c.beginPath();
    pixels.forEach(({ column, begin, sum, count }, place) => {
      const before = pixels[place - 1], x = left + column + 0.5;
      const joined = before && begin - before.end <= hold;
      if (joined && step) c.lineTo(x, py(before.last));
      c[joined ? 'lineTo' : 'moveTo'](x, py(sum / count));
    });
    c.stroke();
  }

  drawSpans({ c, px, left, wide, height, within }, rows) {
    const high = (height - 14) / rows.length;
    c.textBaseline = 'middle';
    rows.forEach(({ name, spans }, row) => {
      const y = row * high, middle = y + high / 2 + 0.5, half = name === HALF;
      within(() => spans.filter(([start, end]) => end >= this.from && start <= this.to)
        .forEach(([start, end, text]) => {
          const x = Math.max(px(start), left - 2);
          const width = Math.max(2, Math.min(px(end), left + wide + 2) - x);
          c.fillStyle = c.strokeStyle = this.color(TINTS[name] || '--faint');
          c.globalAlpha = half ? 0.25 : 0.85;
          c.fillRect(x, y + 2, width, high - 3);
          c.globalAlpha = 1;
          if (half) c.strokeRect(x, y + 2, width, high - 3);
          c.fillStyle = this.color(half ? '--ink' : '--card');
          if (c.measureText(text).width + 6 <= width) c.fillText(text, x + 3, middle);
        }));
      c.fillStyle = this.color('--faint');
      c.textAlign = 'right';
      c.fillText(name.length > 8 ? `${name.slice(0, 7)}.` : name, left - 4, middle);
      c.textAlign = 'left';
    });
  }

  valueAt(chart, { times, values, hold }, time) {
    if (chart.rows) {
      return chart.rows.flatMap(({ name, spans }) => spans
        .filter(([start, end]) => start <= time && (time < end || end > this.last - 0.002))
        .map(([, , text]) => (name === HALF ? text : `${name} ${text}`))).join(', ') || '–';
    }
    const at = indexAt(times, time);
    if (at < 0 || time - times[at] > hold || Number.isNaN(values[at])) return '–';
    return values[at].toFixed(chart.digits);
  }
}

const leftOf = canvas => (canvas.clientWidth < NARROW ? NARROW_LEFT : LEFT);
const wideOf = canvas => Math.max(1, canvas.clientWidth - leftOf(canvas) - RIGHT);

// The index of the last time that is not after `time`; -1: there is none.
export function indexAt(times, time) {
  let low = 0, high = times.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (times[middle] <= time) low = middle + 1;
    else high = middle;
  }
  return low - 1;
}
