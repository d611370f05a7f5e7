# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
A model of how a driver ends: node, dead-man, pipe and line; every order of their steps.

Each process is a short program; a write may be cut after any byte. Between two steps anything may
happen: the node is killed, suspended or continued, the dead-man is killed, the cable is pulled, a
write fails. `explore` visits every state that this can lead to. `test_end_model` ties the steps
to the real code.
"""

from collections.abc import Iterator
from typing import NamedTuple

from create_oi_ros import oi
from create_oi_ros.driver import DEAD_MAN_STOP
from create_oi_ros.driver.outbox import HALT, WAKE_UP

WAKE = WAKE_UP + oi.Start().encode() + oi.Safe().encode()
DRIVE = oi.DriveDirect(right=-400, left=401).encode()
"""Its bytes hold no opcode but the first, and none that a cut would make harmless."""
FAREWELL = HALT.encode() + oi.Start().encode()

# What a node does next, and what follows. '' is the end.
CLOSED, OPENED, GUARDED, READY, CLOSING, RELEASING, LOSING, WAITING, GONE = (
    'closed', 'opened', 'guarded', 'ready', 'closing', 'releasing', 'losing', 'waiting', 'gone')
# A dead-man's states.
NONE, WATCHES, SUSPECTS, SPEAKS, SPEAKS_AND_WATCHES = (
    'none', 'watches', 'suspects', 'speaks', 'speaks and watches')


class Robot(NamedTuple):
    """The part of a command that it has heard, whether it obeys, and whether it drives."""

    pending: bytes = b''
    obeys: bool = False
    drives: bool = False

    def hear(self, byte: int) -> 'Robot':
        """Take a byte, as the Open Interface does (`oi.CommandReader`)."""
        heard = self.pending + bytes([byte])
        kind = oi.Command.by_opcode.get(heard[0])
        if kind is not None and len(heard) < kind.size(heard):
            return self._replace(pending=heard)
        command = None if kind is None else kind.decode(heard)
        after = self._replace(pending=b'')
        match command:
            case oi.Start():
                return after._replace(obeys=False, drives=False)
            case oi.Safe():
                return after._replace(obeys=True)
            case oi.DriveDirect(right=right, left=left) if self.obeys:
                return after._replace(drives=bool(right or left))
        return after


class State(NamedTuple):
    """Everything that decides what can happen next."""

    node: str = CLOSED
    writing: bytes = b''
    """What is left of the node's write."""
    suspended: bool = False
    dead_man: str = NONE
    words: bytes = b''
    """What is left of the last words."""
    pipe: str = ''
    """What the dead-man can read of the pipe: nothing, a goodbye, or its end."""
    cable: bool = True
    robot: Robot = Robot()
    reached: bool = False
    """Whether the robot was reached since the cable was plugged in last."""
    unguarded: bool = False
    """Whether the dead-man was killed and the node has not started another (within 0.1 s)."""
    faults: tuple[str, ...] = ()
    """What has gone wrong so far."""


Steps = Iterator[tuple[str, State]]


def steps(state: State, most_faults: int) -> Steps:
    """Yield what can happen next, by name, and what it leads to."""
    if state.node != GONE and not state.suspended:
        yield from _node(state)
    if state.dead_man != NONE:
        yield from _dead_man(state)
    if len(state.faults) < most_faults:
        for name, after in _faults(state):
            yield name, after._replace(faults=(*state.faults, name))


def _node(s: State) -> Steps:
    if s.writing:
        yield 'node writes', _wrote(s, 'writing') if s.cable else _failed(s)
        return
    match s.node:
        case 'closed' if s.cable:
            yield 'node opens', s._replace(node=OPENED)
        case 'opened':
            yield 'node starts dead-man', _guarded(s)._replace(node=GUARDED)
        case 'guarded':
            yield 'node wakes the robot', s._replace(node=READY, writing=WAKE)
        case 'ready':
            if s.dead_man == NONE:
                yield 'node starts dead-man', _guarded(s)
            yield 'node drives', s._replace(writing=DRIVE)
            yield 'node stops', s._replace(writing=HALT.encode())
            yield 'node ends', s._replace(node=CLOSING, writing=FAREWELL)
        case 'closing':
            yield 'node says goodbye', s._replace(node=WAITING, pipe='goodbye')
        case 'losing':
            yield 'node gives up the line', s._replace(node=RELEASING, pipe='end')
        case 'releasing' if s.dead_man == NONE:
            yield 'node closes', s._replace(node=CLOSED)
        case 'waiting' if s.dead_man == NONE:
            yield 'node closes', s._replace(node=GONE)


def _failed(s: State) -> State:
    """Give up a line that takes no bytes: to open it again, or to end."""
    if s.node == CLOSING:
        return s._replace(writing=b'', node=WAITING, pipe='end')
    return s._replace(writing=b'', node=LOSING)


def _guarded(s: State) -> State:
    return s._replace(dead_man=WATCHES, pipe='', words=b'', unguarded=False)


def _dead_man(s: State) -> Steps:
    if s.words:
        if not s.cable:
            yield 'dead-man fails to write', s._replace(words=b'')
        else:
            yield 'dead-man writes', _wrote(s, 'words')
    elif s.dead_man == SPEAKS:
        yield 'dead-man ends', s._replace(dead_man=NONE)
    elif s.pipe == 'goodbye':
        yield 'dead-man hears goodbye', s._replace(dead_man=NONE)
    elif s.pipe == 'end':
        yield 'dead-man hears the end', s._replace(dead_man=SPEAKS, words=DEAD_MAN_STOP)
    elif not s.suspended:
        if s.dead_man != WATCHES:
            yield 'dead-man sees it run', s._replace(dead_man=WATCHES)
    elif s.dead_man == WATCHES:
        yield 'dead-man suspects', s._replace(dead_man=SUSPECTS)
    else:
        yield 'dead-man sees it suspended', s._replace(
            dead_man=SPEAKS_AND_WATCHES, words=DEAD_MAN_STOP)


def _wrote(s: State, what: str) -> State:
    """Let the robot hear a byte, and the zeros after it that change nothing."""
    rest: bytes = getattr(s, what)
    robot = s.robot.hear(rest[0])
    rest = rest[1:]
    if robot == robot.hear(0):
        rest = rest.lstrip(b'\0')
    return s._replace(robot=robot, reached=True, **{what: rest})


def _faults(s: State) -> Steps:
    """
    Yield what may go wrong.

    Not both at once of what can stop the robot: a node whose dead-man was killed is not killed
    before it has started another, and its last write does not fail.
    """
    alive = s.node != GONE
    if alive and not s.unguarded:
        yield 'node is killed', s._replace(
            node=GONE, writing=b'', suspended=False, pipe=s.pipe or 'end')
    if alive and not s.suspended:
        yield 'node is suspended', s._replace(suspended=True)
    if alive and s.suspended:
        yield 'node is continued', _continued(s)
    if alive and not s.suspended and s.dead_man in (WATCHES, SUSPECTS) and not s.pipe:
        yield 'dead-man is killed', s._replace(dead_man=NONE, words=b'', unguarded=True)
    if s.cable:
        yield 'cable is pulled', s._replace(cable=False, reached=False)
    elif alive:
        yield 'cable is plugged in', s._replace(cable=True)
    if alive and not s.suspended and s.writing and not (s.unguarded and s.node == CLOSING):
        yield 'write fails', _failed(s)


def _continued(s: State) -> State:
    """Go on: the rest of a write is written, then the robot is stopped (`check_standstill`)."""
    stop = HALT.encode() if s.node == READY else b''
    return s._replace(suspended=False, writing=s.writing + stop)


def is_bad(s: State) -> bool:
    """Tell whether nobody is left to stop wheels that turn, on a robot within reach."""
    replaced_soon = s.unguarded and s.node != GONE
    silent = s.dead_man == NONE and not replaced_soon
    return (s.node == GONE or s.suspended) and silent and s.robot.drives and s.reached


class Found(NamedTuple):
    """How many states there are, how many end everything, and a way to a bad one, if any."""

    states: int
    ends: int
    bad: tuple[str, ...] | None
    names: frozenset[str]
    """The steps that were taken anywhere."""


def explore(most_faults: int) -> Found:
    """Visit every state; stop at the first bad one, the nearest."""
    start = State()
    came: dict[State, tuple[State, str] | None] = {start: None}
    frontier, names, ends = [start], set[str](), 0
    while frontier:
        following = []
        for state in frontier:
            if is_bad(state):
                return Found(len(came), ends, _way(came, state), frozenset(names))
            count = 0
            for name, after in steps(state, most_faults):
                count += 1
                names.add(name)
                if after not in came:
                    came[after] = state, name
                    following.append(after)
            ends += not count
        frontier = following
    return Found(len(came), ends, None, frozenset(names))


def _way(came: dict[State, tuple[State, str] | None], state: State) -> tuple[str, ...]:
    way: list[str] = []
    while (step := came[state]) is not None:
        state, name = step
        if not way or way[-1] != name:
            way.append(name)
    return tuple(reversed(way))
