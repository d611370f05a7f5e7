// Copyright 2026 create_oi_ros contributors
// SPDX-License-Identifier: Apache-2.0
// What of the map stands still, drawn once, on a canvas that is larger than the map: a frame of a
// map that follows the robot only moves it.

const BEYOND = 200;  // pixels around the map

export class StillLayer {
  constructor() {
    this.canvas = document.createElement('canvas');
    this.context = this.canvas.getContext('2d');
    this.made = null;  // the centre of what is drawn, and its stamp
  }

  // Put the layer on the map. It is painted anew when its stamp changes, or the map leaves it.
  show(map, stamp, paint) {
    const beyond = Math.round(BEYOND * map.ratio), zoom = map.scale * map.ratio;
    const whole = [stamp, map.scale, map.ratio, map.width, map.height].join();
    const away = () => [(this.made.x - map.center.x) * zoom, (map.center.y - this.made.y) * zoom];
    if (this.made?.whole !== whole || away().some(each => Math.abs(each) > beyond)) {
      this.made = { ...map.center, whole };
      this.paint(map, beyond, zoom, paint);
    }
    const [dx, dy] = away().map(Math.round);
    map.context.setTransform(1, 0, 0, 1, 0, 0);
    map.context.drawImage(this.canvas, dx - beyond, dy - beyond);
  }

  paint(map, beyond, zoom, paint) {
    const { canvas, context: c } = this;
    canvas.width = map.canvas.width + 2 * beyond;
    canvas.height = map.canvas.height + 2 * beyond;
    c.setTransform(zoom, 0, 0, -zoom, canvas.width / 2 - map.center.x * zoom,
                   canvas.height / 2 + map.center.y * zoom);
    c.lineCap = c.lineJoin = 'round';
    const [w, h] = [canvas.width / 2 / zoom, canvas.height / 2 / zoom];
    paint(c, { left: map.center.x - w, right: map.center.x + w,
               low: map.center.y - h, high: map.center.y + h });
  }
}
