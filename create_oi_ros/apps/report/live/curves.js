// Copyright 2026 create_oi_ros contributors
// SPDX-License-Identifier: Apache-2.0
// Curves as they come in the file, and what of them a pixel shows.

// The file has steps of whole numbers; null is a value that is not known.
export function decode({ unit, steps }) {
  const values = new Float64Array(steps.length);
  let whole = 0;
  steps.forEach((step, at) => {
    if (step === null) { values[at] = NaN; return; }
    whole += step;
    values[at] = whole * unit;
  });
  return values;
}

export async function unpack(text) {
  const raw = Uint8Array.from(atob(text), each => each.charCodeAt(0));
  const stream = new Blob([raw]).stream().pipeThrough(new DecompressionStream('deflate'));
  return new Response(stream).json();
}

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

// For each of `columns` pixels: its first index, and least, greatest, mean and last value.
export function perPixel(times, values, from, to, columns) {
  const found = [];
  let at = Math.max(0, indexAt(times, from));
  const end = Math.min(times.length, indexAt(times, to) + 2);
  for (let column = 0; column < columns && at < end; column += 1) {
    const until = from + (column + 1) / columns * (to - from);
    let low = Infinity, high = -Infinity, sum = 0, count = 0;
    const first = at;
    for (; at < end && times[at] < until; at += 1) {
      const value = values[at];
      if (Number.isNaN(value)) continue;
      low = Math.min(low, value); high = Math.max(high, value);
      sum += value; count += 1;
    }
    if (count) found.push({ column, first, low, high, mean: sum / count });
  }
  return found;
}

// How many points lie in a period: with few of them, each is drawn.
export function countBetween(times, from, to) {
  return indexAt(times, to) - Math.max(0, indexAt(times, from)) + 1;
}
