# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""The picture of `create_view`: any state fits any terminal, and alarms are visible."""

from math import cos, hypot, inf, nan, pi, sin
import re

from create_oi_msgs.msg import Bumper, Charging, Cliff, IrOmni, Mode, Song, Wall, WheelDrop
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from geometry_msgs.msg import Quaternion, Twist, Vector3
from hypothesis import given, HealthCheck, settings
from hypothesis import strategies as st
from nav_msgs.msg import Odometry
import pytest
from sensor_msgs.msg import BatteryState, JointState

from create_oi_ros.apps.view import panels
from create_oi_ros.apps.view.keys import BINDINGS
from create_oi_ros.apps.view.picture import KEYS, LEAST_COLUMNS, LEAST_ROWS, PANEL, picture
from create_oi_ros.apps.view.robot_state import (
    CallStatus,
    MOST_POINTS,
    OdomPose,
    RobotState,
    Trail,
)
from create_oi_ros.characters.canvas import Canvas
from create_oi_ros.characters.ink import encoded, has_colors, Ink
from create_oi_ros.ros import messages, topics
from support.anything import anything

OF_STATE = [topic for topic in topics.PUBLISHED
            if topic.type is not DiagnosticArray and topic not in (topics.TF, topics.CONTACTS)]
HEARD = [topic.type for topic in OF_STATE]
HULL = 3
"""Cells from the robot's arrow within which dots are those of its hull."""
SIZES = st.tuples(st.integers(LEAST_COLUMNS, 200), st.integers(LEAST_ROWS, 60))


def odom(x: float = 0.0, y: float = 0.0, yaw: float = 0.0, linear: float = 0.0) -> Odometry:
    """Return an odometry message."""
    made = Odometry()
    made.pose.pose.position.x, made.pose.pose.position.y = x, y
    made.pose.pose.orientation = Quaternion(z=sin(yaw / 2), w=cos(yaw / 2))
    made.twist.twist.linear.x = linear
    return made


def status(name: str, level: bytes, message: str, **values: object) -> DiagnosticStatus:
    """Return a status of the driver, its name without the node's."""
    return DiagnosticStatus(name=name, level=level, message=message, values=[
        KeyValue(key=key.replace('_', ' '), value=str(value)) for key, value in values.items()])


def heard(*messages: object, at: float = 0.0) -> RobotState:
    """Return a state that has received these messages."""
    state = RobotState(title='create_view  /create', driver_listens=True)
    for message in messages:
        state.update(message, at)
    return state


def shown(state: RobotState, columns: int = 80, rows: int = 24, now: float = 0.0, *,
          plain: bool = False) -> str:
    """Return the text on the screen."""
    return '\n'.join(picture(state, now, columns, rows, plain=plain).lines())


def panel(state: RobotState, about: str, now: float = 0.0) -> tuple[str, bool]:
    """Return a line of the panel, and whether any of it is highlighted."""
    line = dict(panels.lines(state, now))[about]
    return ' '.join(piece.text.strip() for piece in line), any(piece.highlighted for piece in line)


def exact(canvas: Canvas) -> bool:
    """Return whether a canvas has its size, and no character that a terminal obeys."""
    lines = canvas.lines()
    return (len(lines) == canvas.rows and all(len(line) == canvas.columns for line in lines)
            and all(line.isprintable() for line in lines)
            and [''.join(text for text, *_ in row) for row in canvas.runs()] == lines)


@settings(max_examples=150, suppress_health_check=list(HealthCheck))
@given(st.data(), SIZES, st.booleans(), st.booleans(), st.floats(0, 1e9))
def test_any_state_fits_any_terminal(data, size, plain, help_shown, now):
    state = RobotState(
        title=data.draw(st.text(max_size=300)), help_shown=help_shown,
        call_status=CallStatus(data.draw(st.text(max_size=300)), highlighted=True))
    for type_ in data.draw(st.lists(st.sampled_from(HEARD), max_size=5)):
        state.update(data.draw(anything(type_)), data.draw(st.floats(0, 1e9)))
    state.diagnostics = {name: status(name, level, text) for name, level, text in data.draw(
        st.lists(st.tuples(st.text(), st.binary(min_size=1, max_size=1), st.text(max_size=200))))}
    state.periods = {topic.type: (topic.name, 0.05) for topic in OF_STATE}
    drawn = picture(state, now, *size, plain=plain)
    assert exact(drawn)
    assert not plain or all(line.isascii() for line in drawn.lines())
    assert KEYS in drawn.lines()[-1]


@pytest.mark.parametrize('rows', [24, 25, 61])
def test_every_width(rows):
    state = heard(odom(1.0, 2.0, 0.5), Mode(mode=2, wanted=2), Bumper(left=True))
    for columns in range(LEAST_COLUMNS, 200):
        drawn = picture(state, 0.0, columns, rows)
        assert exact(drawn)
        assert 'SAFE' in '\n'.join(drawn.lines())


@pytest.mark.parametrize('columns', [0, 1, 7, 40, 79])
@pytest.mark.parametrize('rows', [0, 1, 5, 23])
def test_a_small_terminal_gets_a_sentence(columns, rows):
    drawn = picture(heard(odom()), 0.0, columns, rows)
    assert exact(drawn)
    if columns * rows > 300:
        assert f'here are {columns} x {rows}' in ' '.join(shown(heard(), columns, rows).split())


@pytest.mark.parametrize('about', [about for about, _ in panels.ROWS if about != 'cargo'])
def test_the_smallest_terminal_shows_every_line(about):
    assert f'│{about:8}' in shown(heard(odom()))


def test_a_large_terminal_gives_a_large_map():
    state = heard(odom(4.0))
    for step in range(40):
        state.update(odom(4.0 - step / 10, 0.0), step / 10)

    def dots(columns: int, rows: int) -> int:
        return sum(0x2800 <= ord(character) < 0x2900
                   for character in shown(state, columns, rows, 4.0))
    assert dots(160, 50) > dots(80, 24) > 10


EIGHTHS = list(zip(range(-3, 5), '↙↓↘→↗↑↖←', strict=True))


@pytest.mark.parametrize(('eighths', 'arrow'), EIGHTHS)
def test_the_robot_looks_where_it_goes(eighths, arrow):
    assert arrow in shown(heard(odom(1.0, 1.0, eighths * pi / 4)))


def test_the_trail_is_drawn_the_right_way_up():
    state = heard()
    for step in range(100):
        state.update(odom(0.02 * step, 0.01 * step), 0.1 * step)
    lines = shown(state, now=10.0).split('\n')
    row, column = next((row, line.index('→')) for row, line in enumerate(lines) if '→' in line)
    dots = [(r, c) for r, line in enumerate(lines) for c, character in enumerate(line)
            if 0x2800 < ord(character) < 0x2900]
    trail = [(r, c) for r, c in dots if hypot(2 * (r - row), c - column) > HULL]
    assert len(trail) > 5
    assert all(r >= row and c <= column for r, c in trail), 'it came from the lower left'


def test_bumps_and_cliffs_are_marked_where_they_happened_once():
    state = heard(odom(0.0, 0.0))
    state.update(Bumper(left=True), 0.0)
    state.update(Bumper(left=True, right=True), 0.1)
    for step in range(100):
        state.update(odom(0.02 * step, 0.0), 0.1 * step)
    state.update(Cliff(front_left=True), 10.0)
    assert [(mark.sign, mark.x > 1) for mark in state.trail.marks] == [('x', False), ('!', True)]
    state.update(odom(1.0, 0.5), 12.0)
    chart = '\n'.join(line.split('│')[0] for line in shown(state, now=12.0).split('\n')[1:-4])
    assert 'x' in chart
    assert '!' in chart


@pytest.mark.parametrize('place', [(nan, 0.0), (inf, 0.0), (1e300, 0.0), (0.0, -1e7)])
def test_an_impossible_position_is_named_and_not_drawn(place):
    state = heard(odom(*place))
    assert 'no place on a map' in shown(state)
    assert not state.trail.points


def test_an_impossible_heading_is_not_drawn():
    lost = odom()
    lost.pose.pose.orientation = Quaternion(z=nan, w=nan)
    assert 'no place on a map' in shown(heard(lost))


def test_a_long_trail_keeps_few_points():
    trail = Trail()
    for step in range(100_000):
        trail.add(OdomPose(0.01 * step, 0.0, 0.0), 0.1 * step)
    assert len(trail.points) <= MOST_POINTS
    assert trail.points[0] == (0.0, 0.0)
    assert trail.points[-1][0] > 990


@given(st.lists(st.tuples(st.floats(-100, 100), st.floats(-100, 100)), max_size=50))
def test_a_jump_starts_a_new_trail(places):
    trail = Trail()
    for second, (x, y) in enumerate(places):
        trail.add(OdomPose(x, y, 0.0), second)
    for (x0, y0), (x1, y1) in zip(trail.points, trail.points[1:], strict=False):
        # Between two points lie at least a second, and those that were too near to be kept.
        assert hypot(x1 - x0, y1 - y0) <= 1.3 + 0.02


def test_the_robot_is_drawn_in_scale_around_its_arrow():
    lines = shown(heard(odom(0.3, 0.3)), 120, 40).split('\n')
    row, column = next((row, line.index('→')) for row, line in enumerate(lines) if '→' in line)
    dots = [(r - row, c - column) for r, line in enumerate(lines) for c, each in enumerate(line)
            if 0x2800 < ord(each) < 0x2900]
    # A cell is 0.05 m wide here, and the robot 0.33 m: more than six cells, three rows.
    assert {min(c for _, c in dots), max(c for _, c in dots)} <= {-4, -3, 3, 4}
    assert {min(r for r, _ in dots), max(r for r, _ in dots)} <= {-2, -1, 1, 2}


def test_colours_say_what_words_say_and_no_color_is_respected():
    state = heard(odom(1.0), Bumper(left=True), Mode(mode=2, wanted=2))
    rows = picture(state, 0.0, 80, 24).runs()
    colored = ''.join(encoded(row, colors=True) for row in rows)
    assert f'\x1b[7;{Ink.BAD.value}mLEFT' in colored and f'\x1b[{Ink.GOOD.value}mSAFE' in colored
    plain = ''.join(encoded(row, colors=False) for row in rows)
    assert set(re.findall(r'\x1b\[([\d;]*)m', plain)) == {'7', '0'}
    assert has_colors({'TERM': 'xterm', 'NO_COLOR': ''})
    assert not has_colors({'TERM': 'xterm', 'NO_COLOR': '1'})
    assert not has_colors({'TERM': 'dumb'}) and not has_colors({})


def test_the_bar_is_at_its_column_whatever_width_a_font_gives_the_dots():
    state = heard()
    for step in range(100):
        state.update(odom(0.02 * step, 0.01 * step), 0.1 * step)
    for row in picture(state, 10.0, 80, 24).runs()[1:-4]:
        assert wide_column(encoded(row, colors=True), '│') == 80 - PANEL - 1


def wide_column(written: str, character: str) -> int:
    """Return the column of a character on a terminal whose Braille is two cells wide."""
    column = 0
    for sequence, shown_text in re.findall(r'\x1b\[([\d;]*[Gm])|([^\x1b])', written):
        if sequence.endswith('G'):
            column = int(sequence[:-1]) - 1
        elif shown_text == character:
            return column
        elif shown_text:
            column += 2 if 0x2800 <= ord(shown_text) < 0x2900 else 1
    return -1


def test_without_messages_it_says_so():
    assert 'Nothing heard yet. Is a driver running' in shown(RobotState(), 120)


def test_a_text_from_outside_cannot_command_the_terminal():
    drawn = shown(heard(Mode(mode=1, wanted=2, reason='\x1b[2Jcliff \u202e\u0301 日本')))
    assert '\x1b' not in drawn
    assert 'SAFE is wanted: ?[2Jcliff ?? ??' in drawn


BATTERY = BatteryState(voltage=15.5, current=-0.48, temperature=24.0, percentage=0.9)


@pytest.mark.parametrize(('message', 'about', 'text', 'highlighted'), [
    (odom(1.0, -2.0), 'pose', 'x +1.000 y -2.000 m', False),
    (odom(1e5, 0.0), 'pose', 'x +1.0e+05 y +0.000 m', False),
    (odom(nan, 0.0), 'pose', 'x +nan y +0.000 m', False),
    (odom(yaw=pi / 2), 'yaw', '+90.0 degrees', False),
    # The quaternion of 270 degrees is as good as that of -90.
    (odom(yaw=3 * pi / 2), 'yaw', '-90.0 degrees', False),
    (odom(yaw=-200 * pi / 180), 'yaw', '+160.0 degrees', False),
    (odom(linear=0.2), 'speed', '+0.200 m/s +0.00 rad/s', False),
    (Twist(linear=Vector3(x=0.3)), 'cmd_vel', '+0.300 m/s +0.00 rad/s', False),
    (JointState(name=messages.WHEEL_JOINTS, velocity=[1.0, -2.0]), 'wheels',
     'L +1.00 R -2.00 rad/s', False),
    (JointState(name=['elbow'], velocity=[1.0]), 'wheels', '-', False),
    (JointState(name=messages.WHEEL_JOINTS), 'wheels', '-', False),
    (Bumper(), 'bumper', 'left right', False),
    (Bumper(left=True), 'bumper', 'LEFT right', True),
    (WheelDrop(caster=True), 'drops', 'left right CASTER', True),
    (Cliff(front_left=True), 'cliffs', 'left FLEFT fright right', True),
    (Wall(wall=True, signal=12), 'wall', 'WALL 12 virtual', True),
    (Wall(virtual_wall=True), 'wall', 'wall 0 VIRTUAL', True),
    (BATTERY, 'battery', '[#############-] 90%', False),
    (BatteryState(percentage=0.1), 'battery', '[#-------------] 10%', True),
    (BatteryState(percentage=nan), 'battery', 'charge not known', False),
    (Charging(state=2, home_base=True), 'charger', 'full charging, home base', False),
    (Charging(state=5), 'charger', 'fault', True),
    (Charging(state=77), 'charger', 'state 77', False),
    (Mode(mode=2, wanted=2), 'mode', 'SAFE', False),
    (Mode(mode=1, wanted=2), 'mode', 'PASSIVE (SAFE wanted)', True),
    (Mode(mode=255, wanted=2), 'mode', 'NO ROBOT (SAFE wanted)', True),
    (Song(number=3, playing=True), 'song', 'plays', False),
    (Song(number=3), 'song', '3 was the last', False),
    (Song(), 'song', 'none yet', False),
    (IrOmni(character=255), 'ir', 'none', False),
    (IrOmni(character=248, name='home_base_red_buoy'), 'ir', '248 red buoy', False),
])
def test_what_the_panel_says(message, about, text, highlighted):
    assert panel(heard(message), about) == (text, highlighted)


def test_song_0_was_the_last_only_if_it_was_heard():
    assert panel(heard(Song(playing=True), Song()), 'song') == ('0 was the last', False)


def test_an_old_command_is_not_shown_as_one():
    assert panel(heard(Twist(linear=Vector3(x=0.3))), 'cmd_vel', 3.0) == ('none for 3 s', False)


def test_a_missing_driver_is_shown():
    assert panel(RobotState(), 'cmd_vel') == ('nobody listens', True)


def test_the_volts_stand_below_the_charge():
    assert '15.50 V -0.48 A 24 C' in shown(heard(BATTERY))


def test_the_link_is_shown_from_the_diagnostics():
    state = heard()
    state.diagnostics = {'serial link': status(
        'serial link', DiagnosticStatus.WARN, 'bytes arrive damaged', frames_per_second=66.7,
        damaged_frames=3)}
    assert panel(state, 'link') == ('66.7 frames/s, 3 damaged', True)
    assert panels.alarms(state, 0.0) == ['serial link: bytes arrive damaged']


@pytest.mark.parametrize(('wall', 'mode', 'alarms'), [
    (9.95, 0.0, ['no odom for 10 s']),
    (7.0, 9.0, ['no odom, wall for 3 s']),
    (2.0, 3.0, ['nothing heard for 7 s: driver or network is gone']),
])
def test_silence_is_an_alarm(wall, mode, alarms):
    state = heard(odom())
    state.update(Wall(), wall)
    state.update(Mode(mode=2, wanted=2), mode)
    state.periods = {Odometry: ('odom', 0.0), Wall: ('wall', 0.05), Mode: ('mode', inf)}
    assert panels.alarms(state, 1.0) == []
    assert panels.alarms(state, 10.0) == alarms


def test_alarms_come_the_worst_first_and_the_mode_once():
    state = heard(Mode(mode=1, wanted=2, reason='the left wheel hangs'))
    state.diagnostics = {name: status(name, level, text) for name, level, text in (
        ('battery', DiagnosticStatus.WARN, 'low: charge it soon'),
        ('safety', DiagnosticStatus.ERROR, 'a wheel is blocked: free it'),
        ('mode', DiagnosticStatus.WARN, 'PASSIVE instead of SAFE'),
        ('driver', DiagnosticStatus.OK, 'driving'))}
    assert panels.alarms(state, 0.0) == [
        'SAFE is wanted: the left wheel hangs', 'safety: a wheel is blocked: free it',
        'battery: low: charge it soon']


def test_driving_in_passive_shows_what_to_do():
    state = heard(Mode(mode=1, wanted=1))
    assert panels.alarms(state, 0.0) == []
    state.driving = True
    assert '2 enters SAFE' in shown(state)


def test_two_drivers_in_one_place_are_an_alarm():
    state = heard(odom())
    state.driver_count = 2
    assert '2 drivers publish here' in shown(state)


def test_a_reply_and_a_wait_are_shown():
    state = heard(odom())
    state.call_status = CallStatus(
        'set_mode: refused, the robot is on a charger', highlighted=True)
    assert 'refused, the robot is on a charger' in shown(state)
    state.call_status = CallStatus('set_mode', waiting_since=1.0)
    assert 'set_mode ... 4 s' in shown(state, now=5.0)


def test_the_help_names_every_key():
    state = heard(odom())
    state.help_shown = True
    drawn = shown(state)
    assert all(each.shown in drawn and each.about in drawn for each in BINDINGS)
