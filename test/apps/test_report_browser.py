# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""The page of a report in a real Chromium, without network."""

from collections.abc import Callable
from pathlib import Path
import re

import pytest

pytest.importorskip('rosbags', reason='no rosbags here: see tools/pins.txt')

from create_oi_ros.apps.report.create_report import main, write
from create_oi_ros.apps.report.recording import Recording
from support import bags
from support.web import OpenPage

SIZES = {'phone': (360, 740), 'tablet': (768, 1024), 'desktop': (1440, 900)}


@pytest.fixture(scope='module')
def page_file(tmp_path_factory) -> Path:
    """Return the page of a bag."""
    folder = tmp_path_factory.mktemp('report')
    bag = bags.write(folder / 'walk', 13.5)
    assert main([str(bag), '-o', str(folder / 'report.html')]) == 0
    return folder / 'report.html'


@pytest.fixture(scope='module')
def browser(browser) -> OpenPage:
    """Return a page of a browser without network."""
    browser.page.context.set_offline(True)
    return browser


@pytest.fixture
def opened(empty_page, page_file) -> Callable[..., OpenPage]:
    """Return a function that opens the page of the bag."""
    def open_page(size: str = 'desktop') -> OpenPage:
        empty_page.open(page_file.as_uri(), *SIZES[size])
        empty_page.until('document.getElementById("chart-list").childElementCount > 5')
        return empty_page
    return open_page


LAST = 'document.getElementById("slider").max'


def blank() -> Recording:
    """Return a recording of 20 s without messages."""
    return Recording('walk', 0.0, 20.0, 80)


def pictures(page: OpenPage, selector: str) -> list[str]:
    """Return what is drawn on each canvas."""
    return [str(each) for each in page.page.locator(selector).evaluate_all(
        'all => all.map(each => each.toDataURL())')]


def values(page: OpenPage) -> list[str]:
    """Return the values at the cursor, of all charts."""
    return [str(each) for each in page.page.locator('.chart-values').all_inner_texts()]


def seek(page: OpenPage, part: float) -> None:
    """Move the slider to a part of the time, by the keyboard's event."""
    page.page.evaluate("""part => {
        const slider = document.getElementById('slider');
        slider.value = part * slider.max;
        slider.dispatchEvent(new Event('input'));
    }""", part)


@pytest.mark.parametrize('size', SIZES)
def test_nothing_is_wider_than_the_page_and_the_slider_moves_map_and_values(opened, size):
    page = opened(size)
    assert page.page.evaluate('document.documentElement.scrollWidth <= innerWidth')
    small = page.page.evaluate("""() => [...document.querySelectorAll('button')]
        .filter(each => each.offsetParent && each.offsetHeight < 32).map(each => each.id)""")
    assert small == [], 'a thumb must hit every button'
    before, shown = pictures(page, '#map-canvas'), values(page)
    seek(page, 0.25)
    page.until(f'Number(document.getElementById("slider").value) < 0.9 * {LAST}')
    page.wait(lambda: pictures(page, '#map-canvas') != before, 'a robot that moves')
    page.until('document.querySelector(".chart-values").textContent.includes("0.2")')
    assert values(page) != shown
    bar = page.page.locator('#time-bar').bounding_box()
    assert bar['y'] + bar['height'] <= SIZES[size][1] + 1, 'the slider is in reach'


def move(page: OpenPage, part: float, selector: str = '.paper canvas') -> None:
    """Move the mouse over a canvas, to a part of its width."""
    box = page.page.locator(selector).first.bounding_box()
    page.page.mouse.move(box['x'] + box['width'] * part, box['y'] + 30)


def time(page: OpenPage) -> float:
    """Return the part of the time that the slider is at."""
    return float(page.page.evaluate(f'document.getElementById("slider").value / {LAST}'))


def test_it_opens_at_the_last_moment_and_an_event_jumps_to_its_time(opened):
    page = opened()
    page.until('document.querySelector(".chart-values").textContent.includes("measured 0.")')
    assert time(page) > 0.9
    assert page.text('#place').startswith('x 0.') and 'heading' in page.text('#place')
    row = page.page.locator('#events tr', has_text='Bump left')
    row.get_by_role('button').click()
    page.wait(lambda: page.text('#clock') == row.locator('button').inner_text(), 'the jump')
    assert 'current' in row.get_attribute('class')
    assert 'bumper left' in page.text('#charts')


def test_the_wheel_scrolls_the_page_and_zooms_with_ctrl(opened):
    page = opened()
    page.until('document.querySelector(".chart-values").textContent.includes("0.")')
    for place in ('#map-canvas', '.paper canvas'):
        page.page.evaluate('scrollTo(0, 0)')
        page.wait(lambda: page.page.evaluate('scrollY') == 0, 'the top')
        move(page, 0.5, place)
        page.page.mouse.wheel(0, 200)
        page.wait(lambda: page.page.evaluate('scrollY') > 100, 'the page scrolls')
    page.page.evaluate('scrollTo(0, 0)')
    move(page, 0.1)
    before = pictures(page, '.paper canvas')
    page.page.keyboard.down('Control')
    page.page.mouse.wheel(0, -600)
    page.page.keyboard.up('Control')
    page.wait(lambda: all(one != other for one, other in zip(
        before, pictures(page, '.paper canvas'), strict=True)), 'all charts zoom')
    page.wait(lambda: time(page) < 0.7, 'the cursor stays in what is shown')


def test_values_follow_the_pointer_and_a_drag_zooms(opened):
    page = opened()
    end, shown = page.text('#clock'), values(page)
    move(page, 0.5)
    page.wait(lambda: page.text('#clock') != end and values(page) != shown, 'values there')
    assert time(page) > 0.9, 'nothing is chosen yet'
    page.page.mouse.move(5, 5)
    page.wait(lambda: page.text('#clock') == end, 'the pointer has left')
    move(page, 0.4)
    page.page.mouse.down()
    move(page, 0.6)
    page.page.mouse.up()
    page.wait(lambda: 0.5 < time(page) < 0.65, 'the cursor is at the end of what is shown')
    page.page.mouse.click(*page.page.evaluate("""() => {
        const box = document.querySelector('.paper canvas').getBoundingClientRect();
        return [box.left + box.width / 2, box.top + 20];
    }"""))
    page.wait(lambda: 0.4 < time(page) < 0.55, 'a click chooses')


def test_pointing_at_the_track_moves_the_cursor(opened):
    page = opened()
    end = page.text('#clock')
    box = page.page.locator('#map-canvas').bounding_box()
    middle = box['x'] + box['width'] / 2
    for y in range(int(box['y']), int(box['y'] + box['height']), 6):
        page.page.mouse.move(middle, y)
        if page.text('#clock') != end:
            break
    there = page.text('#clock')
    assert there != end
    page.page.mouse.down()
    page.page.mouse.up()
    page.page.mouse.move(5, 5)
    page.wait(lambda: page.text('#clock') == there, 'a click on the track chooses its time')


def test_times_of_day_and_signals_are_chosen(opened):
    page = opened()
    page.page.locator('#utc').click()
    for text in (page.text('#clock'), page.page.locator('#events button').first.inner_text()):
        assert re.fullmatch(r'\d\d:\d\d:\d\d\.\d', text)
    page.page.locator('#utc').click()
    assert page.page.locator('#events button').first.inner_text().startswith('0:')
    count = page.page.locator('figure:visible').count()
    page.page.locator('.chart-choice summary').click()
    page.page.get_by_label('Battery, V', exact=True).uncheck()
    page.page.get_by_label('Forward, m/s: commanded', exact=True).uncheck()
    assert page.page.locator('figure:visible').count() == count - 1
    assert 'commanded' not in page.page.locator('figure').first.inner_text()


def show(page: OpenPage, folder: Path, made: Recording) -> None:
    """Open the page of a recording."""
    write(made, folder / 'report.html')
    page.open((folder / 'report.html').as_uri(), 800, 800)


@pytest.mark.parametrize('jumps', [True, False])
def test_the_track_is_coloured_over_time_and_a_jump_breaks_it(empty_page, tmp_path, jumps):
    """It drives along y = 0, then y = 9 m; the way between leads past 45 px left of the middle."""
    made = blank()
    for tick in range(80):
        made.odom.add(tick / 4, tick % 40 * 9 / 39, 9.0 * (tick >= 40), 0.0, 0.5, 0.0)
    if jumps:
        made.events.jumps.change(10.0, 'jumps by 12.73 m (reset_pose)')
    show(empty_page, tmp_path, made)
    empty_page.until('document.getElementById("place").textContent.startsWith("x 9.00")')
    empty_page.wait(lambda: empty_page.page.evaluate("""() => {
        const canvas = document.getElementById('map-canvas'), c = canvas.getContext('2d');
        const data = (...box) => c.getImageData(...box).data, { width, height } = canvas;
        const has = (box, like) => data(...box).some((red, at, all) => at % 4 === 0
            && all[at + 3] === 255 && like(red, all[at + 2]));
        return [has([0, height / 2, width, height / 2], (red, blue) => blue > red + 90),
                has([0, 0, width, height / 2], (red, blue) => red > 200 && blue < 30),
                data(width / 2 - 49, height / 2 - 4, 8, 8).some(each => each)];
    }""") == [True, True, not jumps], 'blue, then amber, and the line between')


def test_what_was_not_recorded_is_left_out_and_named(empty_page, tmp_path):
    made = blank()
    made.heard.add('mode')
    made.events.spans['mode'].change(0.0, 'SAFE')
    made.events.finish(20.0)
    show(empty_page, tmp_path, made)
    empty_page.page.get_by_text('Not recorded: odom, cmd_vel, battery_state, diagnostics, bumper, '
                                'cliff, wheel_drop').wait_for()
    assert empty_page.page.locator('figure').count() == 1
    assert empty_page.text('figure').split() == ['What', 'holds', 'SAFE']
    assert empty_page.page.locator('#map-canvas:visible, #place:visible').count() == 0


def test_keys_and_the_play_button_move_the_time(opened):
    page = opened()
    page.page.keyboard.press('Home')
    page.until('document.getElementById("clock").textContent === "0:00.0"')
    page.page.keyboard.press('ArrowRight')
    page.until('document.getElementById("clock").textContent === "0:01.0"')
    page.page.get_by_role('button', name='Play').click()
    page.until(f'document.getElementById("slider").value === {LAST}')
    page.page.get_by_role('button', name='Play').wait_for()
