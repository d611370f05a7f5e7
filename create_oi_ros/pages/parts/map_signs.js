// Copyright 2026 create_oi_ros contributors
// SPDX-License-Identifier: Apache-2.0
// The signs of the map. Each kind has a shape of its own: nobody needs the colours.

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
