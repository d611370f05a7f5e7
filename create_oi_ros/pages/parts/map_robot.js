// Copyright 2026 create_oi_ros contributors
// SPDX-License-Identifier: Apache-2.0
// The robot on the map, in scale; where it really is; and how sure the odometry is of its place.

const SIGMAS = 2;           // of the ellipse
const LEAST_ARROW = 9;      // pixels: the arrow is seen from afar

export function drawRobot(c, { x, y, yaw }, radius, bump, color, pixel) {
  c.save();
  c.translate(x, y);
  c.rotate(yaw);
  c.lineWidth = 2 * pixel;
  c.fillStyle = color('--robot');
  c.strokeStyle = color('--ink');
  c.beginPath();
  c.arc(0, 0, radius, 0, 7);
  c.fill();
  c.stroke();
  for (const [on, from, to] of [[bump.left, 0, Math.PI / 2], [bump.right, -Math.PI / 2, 0]]) {
    if (!on) continue;
    c.strokeStyle = color('--bump');
    c.lineWidth = Math.max(0.035, 5 * pixel);
    c.beginPath();
    c.arc(0, 0, radius, from, to);
    c.stroke();
  }
  const arrow = Math.max(radius, LEAST_ARROW * pixel);
  c.fillStyle = color('--ink');
  c.beginPath();
  c.moveTo(0.8 * arrow, 0);
  c.lineTo(-0.45 * arrow, 0.45 * arrow);
  c.lineTo(-0.2 * arrow, 0);
  c.lineTo(-0.45 * arrow, -0.45 * arrow);
  c.closePath();
  c.fill();
  c.restore();
}

// A dashed ring with a heading, as [x, y, yaw].
export function drawRing(c, [x, y, yaw], radius, color, pixel) {
  c.strokeStyle = color;
  c.lineWidth = 2 * pixel;
  c.setLineDash([4 * pixel, 4 * pixel]);
  c.beginPath();
  c.arc(x, y, radius, 0, 7);
  if (yaw !== null) {
    c.moveTo(x, y);
    c.lineTo(x + radius * Math.cos(yaw), y + radius * Math.sin(yaw));
  }
  c.stroke();
  c.setLineDash([]);
}

export function drawEllipse(c, { x, y }, [xx, xy, yy], color, pixel) {
  if ([xx, xy, yy].some(each => each === null)) return;
  const middle = (xx + yy) / 2;
  const apart = Math.hypot((xx - yy) / 2, xy);
  const [long, short] = [middle + apart, Math.max(0, middle - apart)]
    .map(variance => SIGMAS * Math.sqrt(variance));
  c.fillStyle = color('--doubt');
  c.strokeStyle = color('--doubt-edge');
  c.lineWidth = 1.5 * pixel;
  c.beginPath();
  c.ellipse(x, y, long, short, Math.atan2(2 * xy, xx - yy) / 2, 0, 7);
  c.fill();
  c.stroke();
}
