// Copyright 2026 create_oi_ros contributors
// SPDX-License-Identifier: Apache-2.0
// The robot seen from above, with everything that it senses lit where it is.

const NS = 'http://www.w3.org/2000/svg';
const PARTS = [
  // name, element, attributes, words when lit
  ['bump-left', 'path', { d: 'M 12 100 A 88 88 0 0 1 96 12 L 96 27 A 73 73 0 0 0 27 100 Z' }, 'bumper left'],
  ['bump-right', 'path', { d: 'M 188 100 A 88 88 0 0 0 104 12 L 104 27 A 73 73 0 0 1 173 100 Z' }, 'bumper right'],
  ['cliff-left', 'rect', { x: 33, y: 76, width: 12, height: 18, rx: 3 }, 'cliff left'],
  ['cliff-front_left', 'rect', { x: 66, y: 37, width: 18, height: 12, rx: 3 }, 'cliff front left'],
  ['cliff-front_right', 'rect', { x: 116, y: 37, width: 18, height: 12, rx: 3 }, 'cliff front right'],
  ['cliff-right', 'rect', { x: 155, y: 76, width: 12, height: 18, rx: 3 }, 'cliff right'],
  ['wall-wall', 'path', { d: 'M 194 62 L 194 90' }, 'wall'],
  ['wall-virtual_wall', 'path', { d: 'M 60 4 L 140 4' }, 'virtual wall'],
  ['drop-left', 'rect', { x: 28, y: 104, width: 16, height: 46, rx: 4 }, 'left wheel hangs'],
  ['drop-right', 'rect', { x: 156, y: 104, width: 16, height: 46, rx: 4 }, 'right wheel hangs'],
  ['drop-caster', 'circle', { cx: 100, cy: 58, r: 7 }, 'caster hangs'],
  ['overcurrent-left_wheel', 'path', { d: 'M 50 112 l -5 14 h 6 l -4 14' }, 'left wheel blocked'],
  ['overcurrent-right_wheel', 'path', { d: 'M 150 112 l -5 14 h 6 l -4 14' }, 'right wheel blocked'],
  ['buttons-play', 'circle', { cx: 84, cy: 128, r: 9 }, 'Play pressed'],
  ['buttons-advance', 'circle', { cx: 116, cy: 128, r: 9 }, 'Advance pressed'],
];

function element(name, attributes, parent) {
  const made = document.createElementNS(NS, name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  parent.append(made);
  return made;
}

export class Body {
  constructor(place, words) {
    this.words = words;
    this.svg = element('svg', { viewBox: '-6 -6 212 212', role: 'img' }, place);
    element('circle', { cx: 100, cy: 100, r: 88, class: 'hull' }, this.svg);
    element('path', { d: 'M 100 74 L 112 98 L 100 92 L 88 98 Z', class: 'ahead' }, this.svg);
    this.parts = new Map();
    for (const [name, kind, attributes, text] of PARTS) {
      const part = element(kind, { ...attributes, class: `part ${name.split('-')[0]}` }, this.svg);
      element('title', {}, part).textContent = text;
      part.id = `part-${name}`;
      this.parts.set(name, { part, text, lit: false });
    }
    this.sign(84, 128, 'M -3 -4 L 4 0 L -3 4 Z');
    this.sign(116, 128, 'M -5 -4 L 0 0 L -5 4 Z M 0 -4 L 5 0 L 0 4 Z');
    this.describe();
  }

  sign(x, y, d) {
    element('path', { d, class: 'sign', transform: `translate(${x} ${y})` }, this.svg);
  }

  // Light what is on: `group` is bump, cliff, wall, drop, overcurrent or buttons.
  light(group, sides) {
    let changed = false;
    for (const [side, on] of Object.entries(sides)) {
      const found = this.parts.get(`${group}-${side}`);
      if (!found || found.lit === on) continue;
      found.lit = on;
      found.part.classList.toggle('lit', on);
      changed = true;
    }
    if (changed) this.describe();
  }

  describe() {
    const lit = [...this.parts.values()].filter(each => each.lit).map(each => each.text);
    const text = lit.length ? lit.join(', ') : 'nothing touched';
    this.words.textContent = text;
    this.words.classList.toggle('alarm', lit.length > 0);
    this.svg.setAttribute('aria-label', `The robot from above: ${text}`);
  }
}
