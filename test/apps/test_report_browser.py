# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""The page of a report in a real Chromium, without network, made from a bag of the simulator."""

from collections.abc import Iterator
from pathlib import Path
import signal

from geometry_msgs.msg import Twist
import pytest

pytest.importorskip('rosbags', reason='no rosbags here: see tools/pins.txt')

from create_oi_ros.apps.report.create_report import main
from support.browser import browsers, OpenPage
from support.ros import Scene, scene

SIZES = {'telephone': (360, 740), 'tablet': (768, 1024), 'desktop': (1440, 900)}


def recorded(stage: Scene, folder: Path) -> Path:
    """Record a robot that drives ahead and is bumped; return the bag."""
    robot = stage.robot()
    stage.node(robot.link)
    recorder = stage.program('create_record', '-o', str(folder / 'walk'))
    publisher = stage.ros.node.create_publisher(Twist, 'cmd_vel', 1)
    stage.ros.until(lambda: publisher.get_subscription_count() == 2, 'driver and recorder')
    command = Twist()
    command.linear.x, command.angular.z = 0.3, 0.5

    def driven(until: float) -> bool:
        publisher.publish(command)
        return robot.body.truth().travelled > until
    stage.ros.until(lambda: driven(0.4))
    robot.soon(lambda: robot.body.force(seconds=0.5, bump_left=1))
    stage.ros.until(lambda: driven(0.6))
    recorder.send(signal.SIGINT)
    assert recorder.ended() == 0
    return folder / 'walk'


@pytest.fixture(scope='module')
def page_file(tmp_path_factory) -> Path:
    """Return the page of a bag that was recorded from the simulator."""
    folder = tmp_path_factory.mktemp('report')
    with scene(folder) as stage:
        bag = recorded(stage, folder)
    assert main([str(bag), '-o', str(folder / 'report.html')]) == 0
    return folder / 'report.html'


@pytest.fixture(scope='module')
def browser():
    """Return one browser for all tests."""
    with browsers() as made:
        yield made


@pytest.fixture
def opened(browser, page_file) -> Iterator[object]:
    """Return a function that opens the page; in the end, it may not have complained."""
    pages = []

    def open_page(size: str = 'desktop') -> OpenPage:
        pages.append(OpenPage(
            browser, page_file.as_uri(), *SIZES[size], offline=True))
        pages[-1].until('document.getElementById("chart-list").childElementCount > 5')
        return pages[-1]
    yield open_page
    for page in pages:
        page.close()
    assert [page.errors for page in pages] == [[] for _ in pages]


LAST = 'document.getElementById("slider").max'


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
    seek(page, 0.9)
    page.until(f'Number(document.getElementById("slider").value) > 0.8 * {LAST}')
    page.wait(lambda: pictures(page, '#map-canvas') != before, 'a robot that moves')
    page.until('document.querySelector(".chart-values").textContent.includes("0.3")')
    assert values(page) != shown
    bar = page.page.locator('#time-bar').bounding_box()
    assert bar['y'] + bar['height'] <= SIZES[size][1] + 1, 'the slider is in reach'


def test_an_event_jumps_to_its_time_and_the_map_shows_it(opened):
    page = opened()
    row = page.page.locator('#events tr', has_text='Bump left')
    row.get_by_role('button').click()
    page.wait(lambda: page.text('#clock') == row.locator('button').inner_text(), 'the jump')
    assert 'current' in row.get_attribute('class')
    assert 'bumper left' in page.text('#charts')


def test_charts_zoom_together_and_the_cursor_is_dragged(opened):
    page = opened()
    chart = page.page.locator('.paper canvas').first
    before = pictures(page, '.paper canvas')
    box = chart.bounding_box()
    page.page.mouse.move(box['x'] + box['width'] / 2, box['y'] + 30)
    page.page.mouse.wheel(0, -600)
    page.wait(lambda: all(one != other for one, other in zip(
        before, pictures(page, '.paper canvas'), strict=True)), 'all charts zoom')
    page.page.mouse.down()
    page.page.mouse.move(box['x'] + box['width'] * 0.6, box['y'] + 30, steps=2)
    page.page.mouse.up()
    page.until(f'Math.abs(document.getElementById("slider").value / {LAST} - 0.5) < 0.15')


def test_keys_and_the_play_button_move_the_time(opened):
    page = opened()
    page.page.locator('.paper canvas').first.focus()
    page.page.keyboard.press('ArrowRight')
    page.until('document.getElementById("clock").textContent === "0:01.0"')
    page.page.keyboard.press('Home')
    page.until('document.getElementById("clock").textContent === "0:00.0"')
    page.page.get_by_role('button', name='Play').click()
    page.until(f'document.getElementById("slider").value === {LAST}')
    page.page.get_by_role('button', name='Play').wait_for()


def test_parameters_are_listed(opened):
    page = opened('telephone')
    page.page.locator('summary').click()
    assert 'max_wheel_speed' in page.text('#settings')


def test_charts_and_their_keys_are_drawn_anew_in_the_dark(opened):
    page = opened()
    drawn = '.paper canvas, .chart-key'
    page.wait(lambda: page.page.locator('.chart-key').count(), 'keys of the lines')
    light = pictures(page, drawn)
    page.page.emulate_media(color_scheme='dark')
    page.wait(lambda: all(one != other for one, other in zip(
        light, pictures(page, drawn), strict=True)), 'all in other colours')
