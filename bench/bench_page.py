# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
How smooth the web page is: `python bench/bench_page.py`, half a minute, a table.

A real Chromium without a window, 1920 x 1080, shows a simulated robot that drives, with ten
minutes of track behind it. The times between two frames and the work in each are measured in the
page, by requestAnimationFrame. The processor also draws what a graphics card draws elsewhere.
"""

from pathlib import Path
import shutil
import sys
from typing import Any

from bench_web import started
from results import Figure, repeated, run
from scene import scene

MINUTES, SPEED, STEP = 10, 0.3, 0.02
"""Of the track, m/s, and metres between two points."""
POINTS = round(MINUTES * 60 * SPEED / STEP)
SECONDS = 10
WARM_UP = 3000
"""Milliseconds until the page has settled."""
TARGET = 59.5
"""Frames a second: all 60 of a display, give or take one at the ends."""
LONGER_TRACK = """
const track = [];
for (let at = 0; at < POINTS; at += 1) {
  const turn = at / 60;
  track.push(0.4 * Math.sqrt(turn) * Math.cos(turn), 0.4 * Math.sqrt(turn) * Math.sin(turn));
}
const Real = WebSocket;
window.WebSocket = class extends Real {
  addEventListener(type, listener) {
    super.addEventListener(type, type !== 'message' ? listener : event => {
      const news = JSON.parse(event.data);
      if (news.anew) news.anew = [...track, ...news.anew];
      listener({ data: JSON.stringify(news) });
    });
  }
};
const ask = requestAnimationFrame.bind(window);
window.frameAsked = ask;
window.work = [];
window.requestAnimationFrame = callback => ask(time => {
  const begun = performance.now();
  callback(time);
  window.work.push(performance.now() - begun);
});
""".replace('POINTS', str(POINTS))
MEASURE = """async seconds => {
  const times = [];
  window.work.length = 0;
  await new Promise(done => {
    const begun = performance.now();
    const next = time => {
      times.push(time);
      if (performance.now() - begun < 1000 * seconds) window.frameAsked(next);
      else done();
    };
    window.frameAsked(next);
  });
  return { gaps: times.slice(1).map((time, at) => time - times[at]), work: window.work };
}"""


def drive(page: Any) -> None:
    """Take the stick, so that the robot drives a circle and every frame is drawn anew."""
    page.wait_for_selector('#chip-link[data-level=good]')
    page.wait_for_timeout(WARM_UP)
    page.click('#zoom-all')
    box = page.locator('#stick').bounding_box()
    x, y = box['x'] + box['width'] / 2, box['y'] + box['height'] / 2
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + box['width'] / 4, y - box['height'] / 4, steps=3)


def frames(port: int) -> dict[str, list[float]]:
    """Return the milliseconds between frames, and those of the page's own work."""
    from playwright.sync_api import sync_playwright
    path = shutil.which('chromium') or sys.exit('no Chromium here: apt-get install chromium')
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=path, args=['--no-sandbox'])
        page = browser.new_page(viewport={'width': 1920, 'height': 1080}, bypass_csp=True)
        page.add_init_script(LONGER_TRACK)
        page.goto(f'http://127.0.0.1:{port}/')
        drive(page)
        found: dict[str, list[float]] = page.evaluate(MEASURE, SECONDS)
        browser.close()
    return found


def measure() -> list[Figure]:
    """Measure all."""
    with scene() as stage:
        _, port = started(stage, Path(stage.control))
        found = frames(port)
    gaps, work = sorted(found['gaps']), found['work']
    rate = 1000 * len(gaps) / sum(gaps)
    late = gaps[round(0.95 * len(gaps)) - 1]
    return [
        Figure('page, ten minutes of track: frames a second', rate, '1/s', TARGET,
               at_least=True, beside=f'95 % of the frames within {late:.1f} ms'),
        repeated('page, ten minutes of track: its own work in a frame', work, 'ms')]


if __name__ == '__main__':
    run('bench_page', measure)
