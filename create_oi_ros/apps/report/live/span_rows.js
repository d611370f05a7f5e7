// Copyright 2026 create_oi_ros contributors
// SPDX-License-Identifier: Apache-2.0
// What held for a while, as bars: a row for each kind.

const TINTS = {
  mode: '--accent', bumper: '--bump', cliff: '--cliff', 'wheel drop': '--drop',
  overcurrent: '--error', buttons: '--faint', song: '--good', charging: '--line-1',
};
const HALF = 'mode';  // its bars lie beside each other: they are outlined, with their names

export function drawSpans({ c, px, wide, height, left, color, from, to }, rows) {
  const high = (height - 14) / rows.length;
  c.font = '10px system-ui, sans-serif';
  rows.forEach(({ name, spans }, row) => {
    const y = row * high;
    c.save();
    c.beginPath(); c.rect(left, 0, wide, height); c.clip();
    for (const [start, end, text] of spans) {
      if (end < from || start > to) continue;
      const x = Math.max(px(start), left - 2);
      const width = Math.max(2, Math.min(px(end), left + wide + 2) - x);
      c.fillStyle = c.strokeStyle = color(TINTS[name] || '--faint');
      c.globalAlpha = name === HALF ? 0.25 : 0.85;
      c.fillRect(x, y + 2, width, high - 3);
      c.globalAlpha = 1;
      if (name === HALF) c.strokeRect(x, y + 2, width, high - 3);
      label(c, color, text, x, y + high / 2 + 0.5, width, name === HALF);
    }
    c.restore();
    c.fillStyle = color('--faint');
    c.textAlign = 'right';
    c.textBaseline = 'middle';
    c.fillText(name.length > 8 ? `${name.slice(0, 7)}.` : name, left - 4, y + high / 2 + 0.5);
    c.textAlign = 'left';
  });
}

function label(c, color, text, x, y, width, dark) {
  if (c.measureText(text).width + 6 > width) return;
  c.textBaseline = 'middle';
  c.fillStyle = color(dark ? '--ink' : '--card');
  c.fillText(text, x + 3, y);
}

// What holds at a time, in words.
export function valueOfSpans(rows, time) {
  const found = rows.flatMap(({ name, spans }) => spans
    .filter(([start, end]) => start <= time && time < end)
    .map(([, , text]) => (name === HALF ? text : `${name} ${text}`)));
  return found.join(', ') || '–';
}
