// Copyright 2026 create_oi_ros contributors
// SPDX-License-Identifier: Apache-2.0
// Strip charts of the last minute. Each line has a dash of its own besides its colour.

const SECONDS = 60;
const DASHES = [[], [6, 3], [2, 3], [9, 3, 2, 3]];
const COLORS = ['--line-1', '--line-2', '--line-3', '--line-4'];
const GAP = 1;  // seconds without a sample that break a line
const CHARTS = [
  // title, unit, digits, least range, lines: place in a sample and name
  ['Speed', 'm/s', 2, [-0.1, 0.1], [[1, '']]],
  ['Turn', 'rad/s', 2, [-0.2, 0.2], [[2, '']]],
  ['Current', 'A', 2, [-0.5, 0], [[3, '']]],
  ['Cliff signals', '', 0, [0, 200], [[4, 'L'], [5, 'FL'], [6, 'FR'], [7, 'R']]],
  ['Wall signal', '', 0, [0, 50], [[8, '']]],
];

export class Charts {
  constructor(place) {
    this.samples = [];
    this.charts = CHARTS.map(([title, unit, digits, range, lines]) => {
      const figure = document.createElement('figure');
      const caption = document.createElement('figcaption');
      const name = document.createElement('span');
      name.textContent = unit ? `${title}, ${unit}` : title;
      const values = document.createElement('span');
      values.className = 'chart-values';
      caption.append(name, values);
      const canvas = document.createElement('canvas');
      canvas.setAttribute('role', 'img');
      canvas.setAttribute('aria-label', `Chart: ${title}`);
      const paper = document.createElement('div');
      paper.className = 'paper';
      paper.append(canvas);
      figure.append(caption, paper);
      place.append(figure);
      new ResizeObserver(() => this.draw()).observe(paper);
      return { canvas, values, digits, range, lines, spans: this.spans(values, lines) };
    });
    matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => {
      for (const chart of this.charts) this.colorKeys(chart);
      this.draw();
    });
    for (const chart of this.charts) this.colorKeys(chart);
  }

  spans(values, lines) {
    return lines.map(([, name], at) => {
      const item = document.createElement('span');
      let key = null;
      if (name) {
        key = document.createElement('canvas');
        key.className = 'chart-key';
        item.append(key, `${name} `);
      }
      const text = document.createElement('b');
      item.append(text);
      values.append(item);
      return { text, name, key, at };
    });
  }

  colorKeys(chart) {
    for (const { key, at } of chart.spans) {
      if (!key) continue;
      const ratio = devicePixelRatio || 1;
      key.width = 16 * ratio; key.height = 8 * ratio;
      const c = key.getContext('2d');
      c.scale(ratio, ratio);
      c.strokeStyle = color(COLORS[at]);
      c.lineWidth = 2;
      c.setLineDash(DASHES[at]);
      c.beginPath(); c.moveTo(0, 4); c.lineTo(16, 4); c.stroke();
    }
  }

  add(samples) {
    this.samples.push(...samples);
    const newest = this.samples.at(-1)[0];
    while (this.samples[0][0] < newest - SECONDS) this.samples.shift();
    this.draw();
  }

  draw() {
    if (!this.charts || !this.samples.length) return;
    for (const chart of this.charts) this.drawOne(chart);
  }

  drawOne({ canvas, digits, range, lines, spans }) {
    const ratio = devicePixelRatio || 1, width = canvas.clientWidth, height = canvas.clientHeight;
    if (!width) return;
    canvas.width = width * ratio; canvas.height = height * ratio;
    const c = canvas.getContext('2d');
    c.scale(ratio, ratio);
    const [low, high] = this.limits(lines, range);
    const newest = this.samples.at(-1)[0];
    const px = time => width - 2 - (newest - time) / SECONDS * (width - 34);
    const py = value => 5 + (high - value) / (high - low) * (height - 10);
    c.strokeStyle = color('--grid');
    c.fillStyle = color('--faint');
    c.font = '10px system-ui, sans-serif';
    c.lineWidth = 1;
    for (const value of new Set([low, high, low < 0 && high > 0 ? 0 : low])) {
      c.beginPath(); c.moveTo(30, py(value)); c.lineTo(width, py(value)); c.stroke();
      c.textAlign = 'right';
      c.textBaseline = 'middle';
      c.fillText(value.toFixed(value === 0 ? 0 : Math.min(digits, 1)), 27, py(value));
    }
    lines.forEach(([place], at) => {
      c.strokeStyle = color(COLORS[at]);
      c.lineWidth = 1.8;
      c.setLineDash(DASHES[at]);
      c.beginPath();
      let last = null;
      for (const sample of this.samples) {
        if (sample[place] === null) { last = null; continue; }
        const broken = last === null || sample[0] - last > GAP;
        c[broken ? 'moveTo' : 'lineTo'](px(sample[0]), py(sample[place]));
        last = sample[0];
      }
      c.stroke();
    });
    const now = this.samples.at(-1);
    for (const { text, at } of spans) {
      const value = now[lines[at][0]];
      text.textContent = value === null ? '–' : value.toFixed(digits);
    }
  }

  limits(lines, [low, high]) {
    for (const sample of this.samples) {
      for (const [place] of lines) {
        if (sample[place] === null) continue;
        low = Math.min(low, sample[place]);
        high = Math.max(high, sample[place]);
      }
    }
    const room = (high - low) * 0.08;
    return [low < 0 ? low - room : low, high > 0 ? high + room : high];
  }
}

function color(name) {
  return getComputedStyle(document.documentElement).getPropertyValue(name).trim();
}
