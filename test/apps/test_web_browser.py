# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""The page of `create_web` in a real browser: it drives, lights up, stops, and asks for tokens."""

from concurrent.futures import ThreadPoolExecutor
from contextlib import closing
import signal

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
import pytest

from create_oi_ros.oi import LedBits
from create_oi_ros.sim.world import shipped
from support.browser import browsers, OpenPage
from support.ros import scene
from support.web import free_port, PageClient, served, standing

SIZES = {'telephone': (360, 740), 'tablet': (768, 1024), 'desktop': (1920, 1080),
         'wall': (2560, 1440), 'notebook': (1280, 720)}
DRIVEN = ('telephone', 'tablet', 'desktop')
LONG = 10.0
"""`cmd_vel_timeout`, s: only page and server stop the wheels in time, not the driver."""


@pytest.fixture(scope='module')
def browser():
    """Return one browser for all tests."""
    with browsers() as made:
        yield made


@pytest.fixture
def stage(tmp_path):
    """Return an empty scene."""
    with scene(tmp_path) as made:
        yield made


@pytest.fixture
def pages(browser):
    """Return a function that opens a page; in the end, none may have complained."""
    opened = []

    def open_page(address, size='desktop'):
        opened.append(OpenPage(browser, address, *SIZES[size]))
        return opened[-1]
    yield open_page
    for page in opened:
        page.close()
    assert [page.errors for page in opened] == [[] for _ in opened]


@pytest.fixture
def robot(stage):
    """Return a simulated robot with a driver."""
    made = stage.robot(world=shipped('empty'))
    stage.node(made.link, cmd_vel_timeout=LONG)
    return made


@pytest.fixture
def shown(stage, robot, pages):
    """Return a function that opens a page that shows the robot, in some size."""
    address = served(stage)[1]

    def show(size='desktop'):
        page = pages(address, size)
        page.live()
        return page
    return show


@pytest.mark.parametrize('size', DRIVEN)
def test_dragging_the_stick_moves_the_robot_and_letting_go_stops_it(stage, robot, shown, size):
    page = shown(size)
    page.grab(0.0, 0.7)
    stage.ros.until(lambda: robot.body.truth().pose.x > 0.05)
    page.until('parseFloat(document.getElementById("speed").textContent) > 0.1')
    assert page.text('#chip-seat') == 'you drive'
    page.page.mouse.up()
    stage.ros.until(lambda: standing(robot))
    assert abs(robot.body.truth().pose.y) < 0.05


def test_nothing_is_wider_than_the_page_and_stop_is_in_reach_everywhere(shown):
    for size, (_, height) in SIZES.items():
        page = shown(size).page
        assert page.evaluate('document.documentElement.scrollWidth <= innerWidth'), size
        for place in (0, 1e6):
            page.evaluate(f'scrollTo(0, {place})')
            box = page.locator('#stop').bounding_box()
            assert box['y'] >= 0 and box['y'] + box['height'] <= height, size
            # Nothing lies over it.
            assert page.evaluate("""() => {
                const box = document.getElementById('stop').getBoundingClientRect();
                return document.elementFromPoint(box.x + box.width / 2, box.y + box.height / 2).id;
            }""") == 'stop', size
        small = page.evaluate("""() => [...document.querySelectorAll('button:not(#piano button)')]
            .filter(each => each.offsetParent && each.offsetHeight < 32).map(each => each.id)""")
        assert small == [], f'{size}: a thumb must hit every button'


@pytest.mark.parametrize('stop', ['button', 'Escape', 'space', 'keyboard'])
def test_stop_stops_while_the_stick_is_still_held(stage, robot, shown, stop):
    page = shown('tablet')
    page.grab(0.0, 0.7)
    stage.ros.until(lambda: not standing(robot))
    match stop:
        case 'button':
            page.page.evaluate("""document.getElementById('stop').dispatchEvent(
                new PointerEvent('pointerdown', {bubbles: true, pointerId: 7}))""")
        case 'keyboard':
            page.page.locator('#stop').focus()
            page.page.keyboard.press('Enter')
        case key:
            page.page.keyboard.press({'space': ' '}.get(key, key))
    stage.ros.until(lambda: standing(robot))
    page.until('document.getElementById("toast").textContent !== ""')
    page.page.mouse.move(300, 300)
    assert standing(robot)
    page.page.mouse.up()
    page.grab(0.0, 0.7)
    stage.ros.until(lambda: not standing(robot))
    page.page.mouse.up()


@pytest.mark.parametrize('end', ['close', 'blur', 'hide'])
def test_a_page_that_goes_or_is_not_looked_at_stops_the_robot(stage, robot, shown, end):
    page = shown('telephone')
    page.grab(0.3, 0.5)
    stage.ros.until(lambda: not standing(robot))
    match end:
        case 'close':
            page.close()
        case 'blur':
            page.page.evaluate('dispatchEvent(new Event("blur"))')
        case 'hide':
            page.page.evaluate("""() => {
                Object.defineProperty(document, 'hidden', {value: true});
                document.dispatchEvent(new Event('visibilitychange'));
            }""")
    stage.ros.until(lambda: standing(robot))


def test_the_arrow_keys_drive_while_they_are_held(stage, robot, shown):
    page = shown().page
    page.keyboard.down('ArrowUp')
    page.keyboard.down('ArrowLeft')
    stage.ros.until(lambda: robot.body.truth().pose.yaw > 0.2 < robot.body.truth().travelled)
    page.keyboard.up('ArrowLeft')
    page.keyboard.up('ArrowUp')
    stage.ros.until(lambda: standing(robot))


def test_the_speed_limit_limits(stage, robot, shown):
    page = shown()
    page.page.locator('#limit').focus()
    for _ in range(10):
        page.page.keyboard.press('ArrowLeft')
    assert page.text('#limit-text') == '0.05 m/s'
    page.grab(0.0, 0.9)
    stage.ros.until(lambda: robot.create.actuators.wheels.left == 50)
    page.page.mouse.up()


def test_what_is_touched_lights_up_and_is_said_in_words(robot, shown):
    page = shown()
    robot.soon(lambda: robot.body.force(bump_left=1))
    page.page.wait_for_selector('#part-bump-left.lit')
    assert page.text('#sensed') == 'bumper left'
    robot.soon(lambda: robot.body.force(bump_left=0, cliff_front_right=1))
    page.page.wait_for_selector('#part-cliff-front_right.lit')
    page.until('document.getElementById("sensed").textContent === "cliff front right"')
    robot.soon(lambda: robot.body.unforce())
    page.until('document.getElementById("sensed").textContent === "nothing touched"')


def test_modes_and_leds_are_set(stage, robot, shown):
    page = shown().page
    page.get_by_role('button', name='Full').click()
    page.wait_for_selector('[data-mode=full][aria-pressed=true]')
    page.locator('#led-advance').check()
    stage.ros.until(lambda: robot.create.lights.bits & LedBits.ADVANCE)
    page.get_by_role('button', name='Play a tune').click()
    stage.ros.until(lambda: robot.create.note is not None)


def test_a_place_is_tapped_on_the_map_and_the_robot_goes_there_until_it_is_cancelled(
        stage, robot, shown):
    opened = shown('telephone')
    page = opened.page
    page.locator('#goal-name').select_option('navigate_to_position')
    box = page.locator('#map-canvas').bounding_box()
    page.locator('#map-canvas').click(
        position={'x': 0.7 * box['width'], 'y': 0.5 * box['height']})
    assert float(page.locator('#goal-x').input_value()) > 0.5
    page.locator('#goal-x').fill('4')
    page.get_by_role('button', name='Go', exact=True).click()
    stage.ros.until(lambda: robot.body.truth().travelled > 0.1)
    opened.until('document.getElementById("goal-text").textContent.includes("m left")')
    page.locator('#goal-cancel').click()
    stage.ros.until(lambda: standing(robot))
    opened.until('document.getElementById("goal-text").textContent.includes("canceled")')
    assert page.locator('#goal-cancel').is_disabled()


def test_a_number_that_is_none_is_not_sent(stage, robot, shown):
    page = shown().page
    page.locator('#goal-distance').fill('')
    page.get_by_role('button', name='Go', exact=True).click()
    assert page.locator('#goal-distance:invalid').count() == 1
    assert page.locator('#goal-text').inner_text() == '' and standing(robot)


def test_another_page_watches_until_it_takes_over(stage, robot, shown):
    first, second = shown(), shown('telephone')
    first.grab(0.0, 0.7)
    stage.ros.until(lambda: not standing(robot))
    second.until('document.getElementById("chip-seat").textContent.startsWith("another page")')
    second.page.get_by_role('button', name='Take over').click()
    stage.ros.until(lambda: standing(robot))
    first.until('document.getElementById("chip-seat").textContent.startsWith("another page")')
    assert second.text('#chip-seat') == 'you drive, 2 pages open'
    first.page.mouse.up()


def press_stop(address: str) -> None:
    """Press STOP as another page does; on a thread without Playwright's event loop."""
    with closing(PageClient(address)) as other:
        other.send('stop')
        other.reply()


def test_stop_on_another_page_lets_the_stick_go(stage, robot, shown):
    page = shown()
    page.grab(0.0, 0.7)
    stage.ros.until(lambda: not standing(robot))
    # A second page in this browser would take the focus, which lets the stick go as well.
    with ThreadPoolExecutor() as pool:
        pool.submit(press_stop, page.page.url).result()
    page.until('document.getElementById("toast").textContent === "STOP was pressed"')
    stage.ros.until(lambda: standing(robot))
    assert page.page.locator('#stick.held').count() == 0
    page.page.mouse.up()


def test_dragging_the_map_ends_following_and_a_button_begins_it(shown):
    page = shown().page
    box = page.locator('#map-canvas').bounding_box()
    page.mouse.move(box['x'] + 200, box['y'] + 200)
    page.mouse.down()
    page.mouse.move(box['x'] + 300, box['y'] + 250, steps=3)
    page.mouse.up()
    page.wait_for_selector('#follow[aria-pressed=false]')
    page.mouse.wheel(0, -300)
    page.get_by_role('button', name='Follow').click()
    page.wait_for_selector('#follow[aria-pressed=true]')


def test_the_token_is_asked_for(stage, robot, pages):
    address = served(stage, '--host', '0.0.0.0')[1]
    base, _, token = address.partition('?token=')
    here = f'http://127.0.0.1:{base.rstrip("/").rpartition(":")[2]}/'
    page = pages(here, 'telephone')
    assert 'Which token?' in page.text('h1')
    page.page.get_by_label('Token').fill('guessed')
    page.page.get_by_role('button', name='Open').click()
    assert 'Which token?' in page.text('h1')
    page.page.get_by_label('Token').fill(token)
    page.page.get_by_role('button', name='Open').click()
    page.live()
    assert 'token' not in page.page.url
    # The browser says that the first two answers were refusals.
    assert all('40' in error for error in page.errors)
    page.errors.clear()


def test_texts_of_others_are_no_html(stage, pages):
    page = pages(served(stage)[1])
    publisher = stage.ros.node.create_publisher(DiagnosticArray, '/diagnostics', 10)
    evil = '<img id=evil src=x onerror=alert(1)>'

    def said():
        publisher.publish(DiagnosticArray(status=[
            DiagnosticStatus(name='create: serial link', message=evil, level=b'\x01'),
            DiagnosticStatus(name='create: driver', message=evil, level=b'\x01')]))
        return evil in page.text('#driver-text')
    stage.ros.until(said)
    assert evil in page.text('#link-text')
    assert page.page.locator('#evil').count() == 0


def test_the_page_comes_back_when_the_server_does(stage, robot, pages):
    port = str(free_port())
    web, address = served(stage, '--port', port)
    page = pages(address)
    page.live()
    web.send(signal.SIGKILL)
    page.until('document.getElementById("chip-link").textContent === "no connection"')
    served(stage, '--port', port)
    page.live()
    assert all('WebSocket' in error for error in page.errors)
    page.errors.clear()


def test_charts_show_the_value_at_the_pointer_and_can_be_held(robot, shown):
    page = shown()
    newest = 'document.querySelector(".chart-values").textContent'
    page.grab(0.0, 0.7)
    page.until(f'parseFloat({newest}) > 0.1')
    page.page.mouse.up()
    page.until(f'parseFloat({newest}) === 0')
    box = page.page.locator('.paper canvas').first.bounding_box()

    shows = (f'new Promise(drawn => requestAnimationFrame(() => requestAnimationFrame(() => '
             f'drawn(parseFloat({newest}) > 0.1))))')

    def driven() -> bool:
        """Look for the drive from the newest to older values."""
        for back in range(2, 60):
            page.page.mouse.move(box['x'] + box['width'] - 6 - back, box['y'] + 20)
            if page.page.evaluate(shows):
                return True
        return False
    page.wait(driven, 'the drive is below the pointer')
    page.page.mouse.move(5, 5)
    page.until(f'parseFloat({newest}) === 0')
    page.page.locator('#chart-pause').click()
    page.grab(0.0, 0.7)
    page.until('parseFloat(document.getElementById("speed").textContent) > 0.1')
    page.page.mouse.up()
    assert page.page.evaluate(f'parseFloat({newest}) === 0'), 'the charts are held'
    page.page.locator('.chart-choice summary').click()
    page.page.get_by_label('Wall signal', exact=True).uncheck()
    assert page.page.locator('figure:visible').count() == 4
