# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
The page of `create_web` in a real browser: it drives, says why not, stops, and asks for tokens.

All tests share one browser, one robot, one driver and one server; each begins with the robot at
the origin, in Safe, with nothing around it but a wall 1.5 m ahead.
"""

from concurrent.futures import ThreadPoolExecutor
from contextlib import chdir, closing
from pathlib import Path
import re
import signal

from create_oi_msgs.srv import SetMode
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from nav_msgs.msg import Odometry
import pytest
from sensor_msgs.msg import BatteryState

from create_oi_ros.oi import LedBits, Mode
from create_oi_ros.sim.world import parse
from support.ros import Ready
from support.web import free_port, LONG, PageClient, Relay, served, stops_in_time

SIZES = {'phone': (360, 740), 'sideways': (740, 360), 'tablet': (768, 1024),
         'desktop': (1440, 900), 'wall': (2560, 1440), 'notebook': (1280, 720)}
GAMEPAD = """
window.pad = null;
window.looks = 0;
navigator.getGamepads = () => {
  window.looks += 1;
  return [window.pad];
};
window.push = (x, y, button = false, age = 0) => {
  window.pad = { connected: true, axes: [x, y], buttons: [{ pressed: button }] };
  Object.defineProperty(window.pad, 'timestamp', { get: () => performance.now() - age });
};
if (location.protocol !== 'about:') localStorage.clear();
window.buzzes = [];
navigator.vibrate = pattern => window.buzzes.push(pattern);
"""


@pytest.fixture(scope='module')
def stage(shared_stage):
    """Return a scene with a robot, a driver and a server."""
    made = shared_stage
    made.ready = Ready(made, parse('wall 1.5 -1 1.5 1', 'room'), cmd_vel_timeout=LONG)
    control = made.ready.robot.open_control()
    with chdir(made.folder):  # recordings go there
        made.address = served(made, '--control', str(control))[1]
    return made


@pytest.fixture
def robot(stage):
    """Return the robot as new."""
    stage.ready.renew()
    return stage.ready.robot


@pytest.fixture(scope='module')
def browser(browser):
    """Return a page of a browser with a gamepad."""
    browser.page.add_init_script(GAMEPAD)
    return browser


@pytest.fixture
def opened(empty_page):
    """Return a function that opens the page of a server, in some size."""
    def open_page(address, size='desktop'):
        empty_page.open(address, *SIZES[size])
        return empty_page
    return open_page


@pytest.fixture
def shown(stage, robot, opened):
    """Return a function that opens a page that shows the robot."""
    def show(size='desktop', address=stage.address):
        page = opened(address, size)
        page.live()
        return page
    return show


@pytest.fixture(scope='module')
def other(stage):
    """Return the address of a server that waits for a driver in the namespace /other."""
    return served(stage, '--ros-args', '-r', '__ns:=/other')[1]


@pytest.fixture
def relay(stage):
    """Return a bad network to the server."""
    with closing(Relay(stage.address)) as made:
        yield made


def why(words: str) -> str:
    """Return an expression: the page says at the stick why the robot does not move."""
    return f"""!document.getElementById('why').hidden
        && document.getElementById('why-text').textContent.includes({words!r})"""


# Driving.

def test_dragging_the_stick_moves_the_robot_and_letting_go_stops_it(stage, robot, shown):
    page = shown('phone')
    for number, size in enumerate(('phone', 'sideways', 'desktop'), 1):
        page.resize(*SIZES[size])
        page.grab(0.0, 0.7)
        stage.ros.until(lambda far=number: robot.body.truth().pose.x > 0.1 * far)
        page.until('parseFloat(document.getElementById("speed").textContent) > 0.1')
        assert page.text('#chip-seat') == 'you drive'
        assert not page.page.locator('#why').is_visible()
        page.page.mouse.up()
        stops_in_time(stage.ros, robot)
    assert abs(robot.body.truth().pose.y) < 0.05


def test_stop_stops_while_the_stick_is_still_held(stage, robot, shown):
    page = shown('tablet')
    for stop in ('button', 'Enter', 'Escape', ' '):
        page.grab(0.0, 0.7)
        stage.ros.until(lambda: not robot.standing)
        if stop == 'button':
            page.evaluate("""document.getElementById('stop').dispatchEvent(
                new PointerEvent('pointerdown', {bubbles: true, pointerId: 7}))""")
        else:
            if stop == 'Enter':
                page.page.locator('#stop').focus()
            page.page.keyboard.press(stop)
        stops_in_time(stage.ros, robot)
        page.until("""document.getElementById('stop-text').hidden
            && document.getElementById('toast').textContent === 'Stopped'""")
        page.page.mouse.move(300, 300)
        assert robot.standing
        page.page.mouse.up()
        page.evaluate("document.getElementById('toast').textContent = ''")


def test_a_page_that_goes_or_is_not_looked_at_stops_the_robot(stage, robot, shown):
    page = shown('phone')

    def drive() -> None:
        page.page.mouse.up()
        page.grab(0.3, 0.5)
        stage.ros.until(lambda: not robot.standing)
    for gone in ('blur', 'pagehide'):
        drive()
        page.evaluate(f"dispatchEvent(new Event('{gone}'))")
        stops_in_time(stage.ros, robot)
    drive()
    page.evaluate("""() => {
        Object.defineProperty(document, 'hidden', { value: true });
        document.dispatchEvent(new Event('visibilitychange'));
    }""")
    stops_in_time(stage.ros, robot)
    drive()
    page.leave()
    stops_in_time(stage.ros, robot)


def test_keys_drive_while_they_are_held(stage, robot, shown):
    page = shown().page
    for times, keys in enumerate((('ArrowUp', 'ArrowLeft'), ('w', 'a')), 1):
        for key in keys:
            page.keyboard.down(key)
        stage.ros.until(lambda least=0.2 * times: robot.body.truth().pose.yaw > least)
        stage.ros.until(lambda least=0.1 * times: robot.body.truth().travelled > least)
        for key in reversed(keys):
            page.keyboard.up(key)
        stops_in_time(stage.ros, robot)


def test_a_gamepad_drives_while_it_is_pushed_and_only_after_it_was_let_go(stage, robot, shown):
    page = shown()

    def push(*arguments: object) -> None:
        """Push the gamepad, and wait until the page has seen it."""
        looks = page.evaluate(f'push({", ".join(map(str, arguments))}), window.looks')
        page.until(f'window.looks > {looks} + 2')

    def drives() -> None:
        def moves() -> bool:
            push(0.05, 0.05)
            push(0, -0.5)
            return not robot.standing
        stage.ros.until(moves)

    def must_be_let_go() -> None:
        """Check that it stands, and drives only after the gamepad was let go."""
        stops_in_time(stage.ros, robot)
        push(0, -0.6)
        stops_in_time(stage.ros, robot)  # a command was on its way, at most
    push(0, -0.5)
    must_be_let_go()
    drives()
    push(0.05, 0.05)
    stops_in_time(stage.ros, robot)
    for end in ('push(0, -0.5, true)',           # a button is STOP
                'push(0, -0.5, false, 10_000)',  # nothing new from it: its battery is empty
                'window.pad = null',             # unplugged
                'document.getElementById("stop").click()'):
        drives()
        page.evaluate(end)
        must_be_let_go()
    drives()
    page.evaluate("""() => {
        document.hasFocus = () => false;
        dispatchEvent(new Event('blur'));
    }""")
    stops_in_time(stage.ros, robot)


def press_stop(address: str) -> None:
    """Press STOP as another page does; on a thread without Playwright's event loop."""
    with closing(PageClient(address)) as other:
        other.send('stop')
        other.reply()


def test_stop_on_another_page_lets_the_stick_go(stage, robot, shown):
    page = shown()
    page.grab(0.0, 0.7)
    stage.ros.until(lambda: not robot.standing)
    # A second page in this browser would take the focus, which lets the stick go as well.
    with ThreadPoolExecutor() as pool:
        pool.submit(press_stop, page.page.url).result()
    page.until('document.getElementById("toast").textContent === "STOP was pressed"')
    stops_in_time(stage.ros, robot)
    assert page.page.locator('#stick.held').count() == 0
    page.page.mouse.up()


# It never pretends.

def test_a_dead_network_does_not_look_live_and_stop_waits_for_its_answer(stage, shown, relay):
    page = shown(address=relay.address)
    relay.freeze()
    page.page.locator('#stop').click()
    page.until("""/^no news for [123] s/.test(document.getElementById('chip-link').textContent)
        && document.getElementById('chip-link').dataset.level === 'error'""")
    assert page.text('#stop').split('\n')[-1] == 'not confirmed'
    assert page.evaluate("getComputedStyle(document.getElementById('mode-text')).opacity") < '0.5'
    page.until(why('no connection'))
    relay.abandon()  # the old connection stays dead: the page makes a new one, and says STOP again
    page.live()
    page.until("document.getElementById('stop-text').hidden")
    assert page.text('#chip-seat') in ('nobody drives', 'you drive'), 'it is one page, not two'


def test_a_network_that_is_too_slow_to_drive_is_said(stage, robot, shown, relay):
    page = shown(address=relay.address)
    page.until(r"/live, \d+ ms/.test(document.getElementById('chip-link').textContent)")
    relay.delay = 0.4
    page.until(why('connection too slow to drive ('))
    page.grab(0.0, 0.7)
    page.page.wait_for_timeout(300)
    assert robot.standing
    page.page.mouse.up()


def test_a_low_battery_trembles_and_values_that_are_old_for_their_topic_are_dimmed(
        stage, opened, other):
    page = opened(other)
    odom = stage.ros.node.create_publisher(Odometry, '/other/odom', 1)
    battery = stage.ros.node.create_publisher(BatteryState, '/other/battery_state', 1)

    def old() -> list[str]:
        odom.publish(Odometry())
        return page.evaluate("[...document.querySelectorAll('.old')].map(each => each.id)")

    def known(percent: int) -> bool:
        battery.publish(BatteryState(percentage=percent / 100))
        return old() == [] and f'{percent} %' in page.text('#battery-text')
    page.page.mouse.click(2, 2)  # browsers let only pages tremble that were touched
    stage.ros.until(lambda: known(50))
    assert page.evaluate('window.buzzes') == []
    stage.ros.until(lambda: known(10))
    assert page.evaluate('window.buzzes') == [[200, 100, 200]], 'a low battery trembles'
    stage.ros.until(lambda: old() == ['chip-battery', 'battery-text'])


def test_the_page_says_why_the_robot_does_not_move_and_what_helps(stage, robot, shown):
    page = shown('phone')
    assert stage.ros.call(SetMode, 'set_mode', mode=Mode.PASSIVE).success
    page.until(why('Passive'))
    page.page.locator('#why-button').click()
    page.live()
    robot.soon(lambda: robot.body.drop(left=True))
    page.until(why('left wheel hangs in the air: put the robot down'))
    robot.soon(lambda: robot.body.drop())
    page.until(why('left wheel hung; it stands again'))
    page.page.locator('#why-button').click()
    page.until("document.getElementById('why').hidden")
    robot.soon(lambda: robot.body.force(bump_left=1))
    page.grab(0.0, 0.6)
    page.until(why('bumper pressed: back off'))
    page.page.mouse.up()
    page.until("document.getElementById('why').hidden")
    robot.soon(lambda: robot.body.unforce())
    robot.soon(lambda: robot.body.hold(left=True, right=True))
    page.grab(0.0, 0.6)
    page.until(f"{why('blocked')} || {why('the wheels stand')}")
    page.page.mouse.up()
    robot.soon(lambda: robot.body.hold())


def test_what_is_touched_lights_up_trembles_and_is_listed(robot, shown):
    page = shown()
    page.page.mouse.click(2, 2)  # browsers let only pages tremble that were touched
    robot.soon(lambda: robot.body.force(bump_left=1))
    page.page.wait_for_selector('#part-bump-left.lit')
    assert page.text('#sensed') == 'bumper left'
    robot.soon(lambda: robot.body.force(bump_left=0, cliff_front_right=1))
    page.page.wait_for_selector('#part-cliff-front_right.lit')
    page.until('document.getElementById("sensed").textContent === "cliff front right"')
    robot.soon(lambda: robot.body.unforce())
    page.until('document.getElementById("sensed").textContent === "nothing touched"')
    assert page.evaluate('window.buzzes') == [80, [80, 60, 80]]
    logged = page.text('#log-list').splitlines()
    assert logged.index('▲ Bump left') > logged.index('▲ Cliff front right')


# Layout.

def covers(page, selector):
    """Return the id of what a finger hits in the middle of an element."""
    return page.locator(selector).evaluate("""element => {
        const box = element.getBoundingClientRect();
        return document.elementFromPoint(box.x + box.width / 2, box.y + box.height / 2)?.id;
    }""")


def test_nothing_is_wider_than_the_page_and_stop_is_in_reach_everywhere(stage, robot, shown):
    page = shown()
    assert stage.ros.call(SetMode, 'set_mode', mode=Mode.PASSIVE).success
    page.until(why('Passive'))
    resize, page = page.resize, page.page
    for size, (width, height) in SIZES.items():
        resize(width, height)
        assert page.evaluate('document.documentElement.scrollWidth <= innerWidth'), size
        for place in (0, 1e6):
            page.evaluate(f'scrollTo(0, {place})')
            for button in ('stop', 'dock'):
                box = page.locator(f'#{button}').bounding_box()
                assert box['y'] >= 0 and box['y'] + box['height'] <= height, size
                assert covers(page, f'#{button}') == button, size
        for control in ('#limit', '#goal-go', '#tune-play', '#led-color'):
            page.locator(control).evaluate("each => each.scrollIntoView({block: 'center'})")
            assert covers(page, control) == control[1:], (
                f'{size}: {control} is hidden by the panel of the stick')
        small = page.evaluate("""() => [...document.querySelectorAll('button:not(#piano button)')]
            .filter(each => each.offsetParent && each.offsetHeight < 32).map(each => each.id)""")
        assert small == [], f'{size}: a thumb must hit every button'
        wide = page.evaluate("""() => [...document.querySelectorAll('figure')]
            .filter(each => each.scrollWidth > each.clientWidth).map(each => each.innerText)""")
        assert wide == [], f'{size}: values stick out of their chart'
    resize(*SIZES['sideways'])
    page.evaluate('scrollTo(0, 0)')
    stick, canvas, stop = (page.locator(each).bounding_box()
                           for each in ('#stick', '#map-canvas', '#stop'))
    assert stick['x'] + stick['width'] <= canvas['x']
    assert canvas['x'] + canvas['width'] <= stop['x'] and canvas['height'] > 300


def touch(fingers, kind, *points):
    """Touch the screen with fingers at these places."""
    fingers.send('Input.dispatchTouchEvent', {
        'type': kind, 'touchPoints': [
            {'x': x, 'y': y, 'id': number} for number, (x, y) in enumerate(points)]})


def test_one_finger_scrolls_the_page_and_two_move_the_map(shown):
    page = shown('phone')
    fingers = page.page.context.new_cdp_session(page.page)
    touch(fingers, 'touchStart', (150, 350))
    for at in range(6):
        kind = 'touchMove' if at else 'touchStart'
        touch(fingers, kind, (150, 350 - 40 * at), (230, 350 - 40 * at))
    touch(fingers, 'touchEnd')
    page.page.wait_for_selector('#follow[aria-pressed=false]')
    assert page.evaluate('scrollY') == 0
    page.page.get_by_role('button', name='Follow').click()
    for at in range(6):
        touch(fingers, 'touchMove' if at else 'touchStart', (150, 350 - 40 * at))
    touch(fingers, 'touchEnd')
    page.until('scrollY > 50')
    assert page.page.locator('#follow[aria-pressed=true]').count() == 1


# Doing.

def test_modes_and_leds_are_set_and_full_only_when_its_button_is_held(stage, robot, shown):
    page = shown().page
    full = page.get_by_role('button', name='Full')
    full.click()
    page.wait_for_selector('#toast:not([hidden])')
    assert page.locator('#toast').inner_text() == 'Hold it: Drives off tables, too'
    assert robot.create.mode is Mode.SAFE
    full.hover()
    page.mouse.down()
    page.evaluate("document.body.style.marginTop = '200px'")  # as a banner moves all below it
    page.wait_for_selector('[data-mode=full][aria-pressed=true]')
    page.mouse.up()
    page.locator('#led-advance').check()
    stage.ros.until(lambda: robot.create.lights.bits & LedBits.ADVANCE)


def test_tunes_are_played_and_notes_that_are_pressed_meanwhile_follow(stage, robot, shown):
    page, heard = shown('phone').page, []

    def listen() -> None:
        if robot.create.note and heard[-1:] != [robot.create.note]:
            heard.append(robot.create.note)
    robot.soon(lambda: robot.watch(listen))
    for name in ('C 5', 'E 5', 'G 5'):
        page.get_by_role('button', name=name, exact=True).click()
    stage.ros.until(lambda: heard == [72, 76, 79])
    page.wait_for_selector('#tune-note:empty', state='attached')
    page.get_by_role('button', name='Play', exact=True).click()
    stage.ros.until(lambda: heard[3:] == [67, 72, 76, 79])
    page.locator('#tune-text').fill('x:d=2,o=5,b=180:c,d,e')
    page.get_by_role('button', name='Play', exact=True).click()
    page.wait_for_selector('#tune-note:has-text("♪ D5, note 2")')
    page.locator('#tune-cancel').click()
    page.wait_for_selector('#tune-note:empty', state='attached')
    assert page.locator('#toast').is_hidden()
    page.locator('#tune-text').fill('H7')
    page.get_by_role('button', name='Play', exact=True).click()
    page.wait_for_selector('#toast:has-text("such as C4:1/4")')


def tap(page, right: float, up: float) -> None:
    """Tap the map this far from its middle, in metres."""
    box = page.page.locator('#map-canvas').bounding_box()
    page.page.touchscreen.tap(box['x'] + box['width'] / 2 + 90 * right,
                              box['y'] + box['height'] / 2 - 90 * up)


def test_places_are_tapped_on_the_map_and_the_robot_goes_from_one_to_the_next(
        stage, robot, shown):
    page = shown('phone')
    tap(page, 0.12, 0.0)
    page.until("document.getElementById('here-go').textContent === 'Go here'")
    tap(page, 0.24, 0.0)
    assert page.text('#here-text') == ''
    page.page.get_by_role('button', name='Go to 2 places').click()
    page.until("document.getElementById('here-text').textContent.includes('m left')")
    stage.ros.until(lambda: robot.body.truth().pose.x > 0.2)
    page.until("document.getElementById('here').hidden")
    assert page.text('#goal-text') == '✓ Go to a place: reached'


def test_a_way_through_a_wall_is_red_and_a_cancel_is_no_error(stage, robot, shown):
    page = shown('phone')
    page.page.locator('#zoom-out').click()
    page.page.locator('#zoom-out').click()
    scale = 1.35 ** -2
    tap(page, 1.65 * scale, -0.9 * scale)
    page.until("document.getElementById('here-text').textContent.includes('through a wall')")
    page.until(f"""(() => {{
        const canvas = document.getElementById('map-canvas');
        const metre = {90 * scale} * devicePixelRatio;
        const x = canvas.width / 2 + 0.825 * metre, y = canvas.height / 2 + 0.45 * metre;
        const around = canvas.getContext('2d').getImageData(x - 15, y - 15, 31, 31).data;
        return around.some((red, i) => i % 4 === 0 && red > 150 && around[i + 1] < 80);
    }})()""")
    page.page.get_by_role('button', name='Clear').click()
    assert not page.page.locator('#here').is_visible()
    tap(page, 1.1 * scale, 0.0)
    page.until("document.getElementById('here-text').textContent === ''")
    page.page.get_by_role('button', name='Go here').click()
    stage.ros.until(lambda: robot.body.truth().pose.x > 0.1)
    page.page.locator('#here-cancel').click()
    stops_in_time(stage.ros, robot)
    page.until("document.getElementById('goal-text').textContent === 'Go to a place: cancelled'")
    assert re.search(r'\bnavigate to position: stopped \d\.\d+ m from the goal; canceled$',
                     page.text('#log-list'), re.MULTILINE)
    assert page.page.locator('#goal-cancel').is_disabled()
    assert page.evaluate("document.getElementById('toast').dataset.level") == 'good'
    page.page.get_by_role('button', name='Clear').click()
    page.page.get_by_role('button', name='Dock').click()
    stage.ros.until(lambda: robot.create.demo is not None)
    page.page.locator('#stop').click()
    stage.ros.until(lambda: robot.create.demo is None)


def test_a_recording_is_made_and_its_report_is_offered(stage, robot, shown):
    page = shown()
    page.page.get_by_role('button', name='Record').click()
    page.until("document.getElementById('record').getAttribute('aria-pressed') === 'true'")
    page.until("document.getElementById('log-list').textContent.includes('recording on')")
    folder = page.text('#record-text').removeprefix('Records to ')
    stage.ros.until(lambda: any(each.stat().st_size > 200_000
                                for each in Path(folder).glob('*.mcap')), 'two seconds')
    page.grab(0.0, 0.5)
    stage.ros.until(lambda: robot.body.truth().pose.x > 0.05)
    page.page.mouse.up()
    page.page.get_by_role('button', name='End the recording').click()
    with page.page.expect_popup() as opened:
        page.page.get_by_role('link', name='Open the report').click(timeout=60_000)
    opened.value.wait_for_selector('#map-canvas')
    assert page.text('#record-text') == folder


# Texts, tokens, other servers.


def test_texts_of_others_are_no_html(stage, opened, other):
    page = opened(other)
    publisher = stage.ros.node.create_publisher(DiagnosticArray, '/diagnostics', 10)
    evil = '<img id=evil src=x onerror=alert(1)>'

    def said():
        publisher.publish(DiagnosticArray(status=[
            DiagnosticStatus(name=f'other/create: {name}', message=evil, level=b'\x01',
                             hardware_id='iRobot Create at x (/other)')
            for name in ('serial link', 'driver')]))
        return evil in page.text('#driver-text')
    stage.ros.until(said)
    assert evil in page.text('#link-text') and evil in page.text('#log-list')
    assert page.page.locator('#evil').count() == 0


def test_the_page_comes_back_when_the_server_does_and_takes_a_new_token(stage, robot, opened):
    port = str(free_port())
    here = f'http://127.0.0.1:{port}/'

    def server():
        web, address = served(stage, '--port', port, '--host', '0.0.0.0')
        return web, address.partition('?token=')[2]
    web, token = server()
    page = opened(here, 'phone')
    assert 'Which token?' in page.text('h1')
    assert not page.page.locator('#wrong').is_visible()
    page.page.get_by_label('Token').fill('guessed')
    page.page.get_by_role('button', name='Open').click()
    page.page.wait_for_selector('#wrong')
    assert 'guessed' not in page.page.url
    page.page.get_by_label('Token').fill(token)
    page.page.get_by_role('button', name='Open').click()
    page.live()
    assert 'token' not in page.page.url
    web.send(signal.SIGKILL)
    page.until("document.getElementById('chip-link').dataset.level === 'error'")
    _, token = server()
    page.until("document.getElementById('banner-text').textContent.includes('another token')")
    assert page.page.locator('#banner-token').is_visible()
    with page.page.context.new_page() as other:  # as a phone does that reads the new QR code
        other.goto(f'{here}?token={token}')
    page.live()
    # The browser says that the first answers were refusals, and of connections that failed.
    assert all('40' in error or 'WebSocket' in error or 'ERR_' in error for error in page.errors)
    page.errors.clear()
