# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""The panel: a line for each sensor and status. Alarms are highlighted."""

from __future__ import annotations

from collections.abc import Callable
from math import degrees, inf, isfinite, isnan
from typing import Any, NamedTuple

from create_oi_msgs import msg
from diagnostic_msgs.msg import DiagnosticStatus
from geometry_msgs.msg import Twist, TwistStamped
from nav_msgs.msg import Odometry
from sensor_msgs.msg import BatteryState, JointState

from ...characters.ink import Ink
from ...ros.diagnostics import LINK
from ...ros.messages import charging_name, mode_name, WHEEL_JOINTS
from .robot_state import RobotState

NOTHING = '-'
"""Shown until the first message."""
LARGEST = 9999
"""Larger numbers are written with an exponent, so that they fit their column."""
BAR = 14
"""Characters of the battery's bar."""
LOW = 0.2
"""Part of the full charge below which the battery is highlighted."""
HALF = 0.5
"""Part of the full charge below which its colour changes."""
SILENCE = 2.5
"""Seconds without any message after which the driver counts as gone."""
MOST_NAMES = 4
"""Topics named in one alarm."""
FRESH = 0.5
"""Seconds for which a velocity command is shown."""


class Piece(NamedTuple):
    """A piece of a line: its column in the panel, its text."""

    column: int
    text: str
    highlighted: bool = False
    ink: Ink = Ink.PLAIN


Line = list[Piece]


def number(value: float, digits: int) -> str:
    """Return a number with its sign, short for any value."""
    if isfinite(value) and abs(value) > LARGEST:
        return f'{value:+.1e}'
    return f'{value:+.{digits}f}'


def plain(*texts: str) -> Line:
    """Return a line without highlights."""
    return [Piece(0, ' '.join(texts))]


def flags(*named: tuple[str, bool], width: int = 7) -> Line:
    """Return names in columns; one that is set is highlighted and in capitals."""
    return [Piece(index * width, name.upper() if is_set else name, is_set,
                  Ink.BAD if is_set else Ink.PLAIN)
            for index, (name, is_set) in enumerate(named)]


def velocity(linear: float, angular: float) -> str:
    """Return a velocity as text."""
    return f'{number(linear, 3)} m/s {number(angular, 2)} rad/s'


def _position(state: RobotState, _: float) -> Line:
    pose = state.pose
    return [] if pose is None else plain(f'x {number(pose.x, 3)} y {number(pose.y, 3)} m')


def _heading(state: RobotState, _: float) -> Line:
    pose = state.pose
    return [] if pose is None else plain(f'{number(degrees(pose.yaw), 1)} degrees')


def _speed(odom: Any) -> Line:
    return plain(velocity(odom.twist.twist.linear.x, odom.twist.twist.angular.z))


def _command(state: RobotState, now: float) -> Line:
    if not state.driver_listens:
        return [Piece(0, 'nobody listens', highlighted=True)]
    type_ = min((Twist, TwistStamped), key=lambda each: state.age(each, now))
    command, age = state.get(type_), state.age(type_, now)
    if command is None:
        return plain('none heard')
    if age > FRESH:
        return plain(f'none for {age:.0f} s' if age < 1000 else 'none for long')
    twist = command.twist if type_ is TwistStamped else command
    return plain(velocity(twist.linear.x, twist.angular.z))


def _wheels(joints: Any) -> Line:
    turning = dict(zip(joints.name, joints.velocity, strict=False))
    left, right = (turning.get(name) for name in WHEEL_JOINTS)
    if left is None or right is None:
        return []
    return plain(f'L {number(left, 2)} R {number(right, 2)} rad/s')


def _bumper(bumper: Any) -> Line:
    return flags(('left', bumper.left), ('right', bumper.right))


def _drops(drop: Any) -> Line:
    return flags(('left', drop.left), ('right', drop.right), ('caster', drop.caster))


def _cliffs(cliff: Any) -> Line:
    return flags(('left', cliff.left), ('fleft', cliff.front_left), ('fright', cliff.front_right),
                 ('right', cliff.right))


def _signals(cliff: Any) -> Line:
    return flags(*((f'{signal:4d}', False) for signal in (
        cliff.left_signal, cliff.front_left_signal, cliff.front_right_signal,
        cliff.right_signal)))


def _wall(wall: Any) -> Line:
    return [*flags(('wall', wall.wall), (f'{wall.signal:4d}', False)),
            Piece(14, 'VIRTUAL' if wall.virtual_wall else 'virtual', wall.virtual_wall)]


def _overcurrent(over: Any) -> Line:
    return flags(('left', over.left_wheel), ('right', over.right_wheel),
                 ('ld0', over.driver_0), ('ld1', over.driver_1), ('ld2', over.driver_2), width=6)


def _charge(battery: Any) -> Line:
    part = battery.percentage
    if isnan(part):
        return plain('charge not known')
    full = round(BAR * min(max(part, 0.0), 1.0))
    ink = Ink.BAD if part < LOW else Ink.WARN if part < HALF else Ink.GOOD
    return [Piece(0, f'[{"#" * full}{"-" * (BAR - full)}] {part:.0%}', part < LOW, ink)]


def _volts(battery: Any) -> Line:
    return plain(f'{battery.voltage:.2f} V {number(battery.current, 2)} A '
                 f'{battery.temperature:.0f} C')


def _charging(charging: Any) -> Line:
    where = [name for name, here in (
        ('home base', charging.home_base), ('charger', charging.internal_charger)) if here]
    text = ', '.join([charging_name(charging.state), *where])
    return [Piece(0, text, charging.state == msg.Charging.FAULT)]


def _mode(mode: Any) -> Line:
    differs = mode.mode != mode.wanted
    wanted = f' ({mode_name(mode.wanted)} wanted)' if differs else ''
    return [Piece(0, mode_name(mode.mode) + wanted, differs, Ink.BAD if differs else Ink.GOOD)]


def _buttons(buttons: Any) -> Line:
    return flags(('play', buttons.play), ('advance', buttons.advance))


def _song(state: RobotState, _: float) -> Line:
    song = state.get(msg.Song)
    if song is None:
        return []
    # The number arrives once a second only: while a song plays, it may be that of the last one.
    if song.playing:
        return plain('plays')
    # A robot that has played no song reports number 0.
    return plain(f'{song.number} was the last' if state.song_played or song.number else 'none yet')


def _infrared(infrared: Any) -> Line:
    name = infrared.name.removeprefix('home_base_').replace('_and_', '+').replace('_', ' ')
    heard = infrared.character != msg.IrOmni.NONE
    return plain(f'{infrared.character} {name}' if heard else 'none')


def _cargo(cargo: Any) -> Line:
    bits = ''.join(str(int(each)) for each in (
        cargo.input_3, cargo.input_2, cargo.input_1, cargo.input_0))
    return plain(f'inputs {bits} analog {cargo.analog:.2f} V')


def _link(state: RobotState, _: float) -> Line:
    link = state.diagnostics.get(LINK)
    if link is None:
        return []
    known = {value.key: value.value for value in link.values}
    highlighted = link.level != DiagnosticStatus.OK
    rate, damaged = known.get('frames per second', '-'), known.get('damaged frames', '-')
    return [Piece(0, f'{rate} frames/s, {damaged} damaged', highlighted,
                  Ink.WARN if highlighted else Ink.PLAIN)]


def of(type_: type, line: Callable[[Any], Line]) -> Callable[[RobotState, float], Line]:
    """Return a line made from the newest message of a type; empty before the first."""
    def made(state: RobotState, _: float) -> Line:
        message = state.get(type_)
        return [] if message is None else line(message)
    return made


Row = tuple[str, Callable[[RobotState, float], Line]]
GROUPS: tuple[tuple[Row, ...], ...] = (
    (('mode', of(msg.Mode, _mode)), ('battery', of(BatteryState, _charge)),
     ('', of(BatteryState, _volts)), ('charger', of(msg.Charging, _charging)), ('link', _link)),
    (('bumper', of(msg.Bumper, _bumper)), ('drops', of(msg.WheelDrop, _drops)),
     ('cliffs', of(msg.Cliff, _cliffs)), ('', of(msg.Cliff, _signals)),
     ('wall', of(msg.Wall, _wall)), ('current', of(msg.Overcurrent, _overcurrent))),
    (('speed', of(Odometry, _speed)), ('cmd_vel', _command), ('pose', _position),
     ('yaw', _heading), ('wheels', of(JointState, _wheels))),
    (('buttons', of(msg.Buttons, _buttons)), ('ir', of(msg.IrOmni, _infrared)), ('song', _song),
     ('cargo', of(msg.CargoBay, _cargo))),
)
"""The panel from top to bottom, in the order people look: may it drive, what touches it, how it
moves, all else. A small terminal leaves out the last lines."""
ROWS: tuple[Row, ...] = tuple(row for group in GROUPS for row in group)


def lines(state: RobotState, now: float, rows: int = 0) -> list[tuple[str, Line]]:
    """Return the label and content of each line; groups are apart if that fits in the rows."""
    apart = len(ROWS) + len(GROUPS) - 1 <= rows
    found: list[tuple[str, Line]] = []
    for group in GROUPS:
        if apart and found:
            found.append(('', []))
        found += [(about, line(state, now) or plain(NOTHING if about else ''))
                  for about, line in group]
    return found


def silences(state: RobotState, now: float) -> list[str]:
    """Return an alarm for topics that have stopped, and for how long at least."""
    if SILENCE < (quiet := state.silence(now)) < inf:
        return [f'nothing heard for {quiet:.0f} s: driver or network is gone']
    missed = state.late_topics(now)
    if not missed:
        return []
    first, more = [*missed][:MOST_NAMES], len(missed) - MOST_NAMES
    names = ', '.join(first) + (f' and {more} more' if more > 0 else '')
    return [f'no {names} for {min(missed.values()):.0f} s']


def alarms(state: RobotState, now: float) -> list[str]:
    """Return all alarms: silence, the mode, warnings of the diagnostics."""
    found, mode = silences(state, now), state.get(msg.Mode)
    if state.driving and mode is not None and mode.mode == mode.wanted == msg.Mode.PASSIVE:
        found.append('in PASSIVE it does not drive: 2 enters SAFE')
    if state.driver_count > 1:
        found.append(f'{state.driver_count} drivers publish here: give each a namespace or domain')
    if mode is not None and mode.reason:
        found.append(f'{mode_name(mode.wanted)} is wanted: {mode.reason}')
    ranked = sorted(state.diagnostics.items(), key=lambda each: each[1].level, reverse=True)
    # The alarm about the mode above says more than the diagnostics.
    return found + [f'{name}: {status.message}' for name, status in ranked
                    if status.level != DiagnosticStatus.OK and name != 'mode']
