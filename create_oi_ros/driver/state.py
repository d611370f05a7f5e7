# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
What the driver is doing, as one value, and what leads from one activity to another.

Everything that changes the activity goes through `State.handle`. `TRANSITIONS` says which events
lead to another activity, `STAYS` which change nothing. An event that neither lists is a mistake of
the driver: tests fail, in the field it is logged and changes nothing. What the robot follows and
takes now, and why a request is refused, follow from the activity; `CONSEQUENCES` says what the
driver does after an event. To add an activity or an event, add a row to each table.

    CLOSED --CALLED--> CALLING --ANSWERED--> IDLE <--VELOCITY/HALTED--> DRIVING
    CALLING --RETURNED--> HOLDING --HALTED--> IDLE; IDLE, DRIVING, ... --MODE_LEFT--> HOLDING
    IDLE --DEMO_STARTED--> DEMO --DEMO_ENDED--> IDLE
    IDLE --SCRIPT_STARTED--> SCRIPT --SCRIPT_ENDED--> IDLE
    IDLE --GOAL_STARTED--> GOAL --DOCKING_STARTED--> DOCKING; both --GOAL_ENDED--> IDLE
    every activity --CALLED--> CALLING, --PORT_CLOSED--> CLOSED
"""

from enum import auto, Enum


class Activity(Enum):
    """What the driver is doing; the value is the text for people."""

    CLOSED = 'port closed'
    CALLING = 'no answer yet'
    IDLE = 'waiting for commands'
    HOLDING = 'waiting until commands pause'
    DRIVING = 'driving'
    DEMO = 'a demo runs'
    GOAL = 'a goal runs'
    DOCKING = 'a goal looks for the dock'
    SCRIPT = 'a script plays'


class StateEvent(Enum):
    """What may change the driver's activity."""

    PORT_CLOSED = auto()
    """The port is gone, or the driver shuts down."""
    ANSWERED = auto()
    """The first frame came."""
    RETURNED = auto()
    """The first frame came after an absence: commands must pause before they are followed."""
    CALLED = auto()
    """The port is open, frames stopped coming, or the driver's process stood still."""
    VELOCITY = auto()
    """A velocity was commanded that is not zero and that the robot may follow."""
    HALTED = auto()
    """The commanded velocity is zero, refused while it was followed, or too old."""
    STOPPED = auto()
    """A stop was requested: send the speeds again."""
    RESTED = auto()
    """The battery is nearly empty, and the user wants the robot to stop then."""
    MODE_LEFT = auto()
    """The robot left the wanted mode by itself: send the speeds again."""
    MODE_ENTERED = auto()
    """The driver sent a mode command: speeds that were sent before it no longer count."""
    MODE_SET = auto()
    """Somebody set a mode in which the robot drives."""
    PASSIVE_SET = auto()
    """Somebody set Passive."""
    DEMO_STARTED = auto()
    DEMO_ENDED = auto()
    GOAL_STARTED = auto()
    """A goal begins that the driver pursues by velocities."""
    DOCKING_STARTED = auto()
    """A goal lets the robot look for its dock."""
    GOAL_ENDED = auto()
    SCRIPT_STARTED = auto()
    SCRIPT_ENDED = auto()


_A, _E = Activity, StateEvent
TRANSITIONS: dict[Activity, dict[StateEvent, Activity]] = {
    _A.CLOSED: {},
    _A.CALLING: {_E.ANSWERED: _A.IDLE, _E.RETURNED: _A.HOLDING},
    _A.IDLE: {
        _E.VELOCITY: _A.DRIVING, _E.GOAL_STARTED: _A.GOAL, _E.MODE_LEFT: _A.HOLDING,
        _E.DEMO_STARTED: _A.DEMO, _E.SCRIPT_STARTED: _A.SCRIPT},
    _A.HOLDING: {
        _E.HALTED: _A.IDLE, _E.MODE_SET: _A.IDLE,
        _E.DEMO_STARTED: _A.DEMO, _E.SCRIPT_STARTED: _A.SCRIPT},
    _A.DRIVING: {
        _E.HALTED: _A.IDLE, _E.STOPPED: _A.IDLE, _E.RESTED: _A.IDLE, _E.PASSIVE_SET: _A.IDLE,
        _E.MODE_LEFT: _A.HOLDING, _E.GOAL_STARTED: _A.GOAL, _E.DEMO_STARTED: _A.DEMO},
    _A.GOAL: {
        _E.GOAL_ENDED: _A.IDLE, _E.STOPPED: _A.IDLE, _E.RESTED: _A.IDLE,
        _E.PASSIVE_SET: _A.IDLE, _E.MODE_LEFT: _A.HOLDING,
        _E.DOCKING_STARTED: _A.DOCKING, _E.DEMO_STARTED: _A.DEMO},
    _A.DOCKING: {
        _E.GOAL_ENDED: _A.IDLE, _E.STOPPED: _A.IDLE, _E.RESTED: _A.IDLE,
        _E.MODE_SET: _A.IDLE, _E.PASSIVE_SET: _A.IDLE, _E.DEMO_ENDED: _A.IDLE,
        _E.DEMO_STARTED: _A.DEMO},
    _A.DEMO: {
        _E.STOPPED: _A.IDLE, _E.RESTED: _A.IDLE, _E.MODE_LEFT: _A.HOLDING,
        _E.MODE_SET: _A.IDLE, _E.PASSIVE_SET: _A.IDLE, _E.DEMO_ENDED: _A.IDLE,
        _E.DEMO_STARTED: _A.DEMO, _E.GOAL_STARTED: _A.GOAL, _E.SCRIPT_STARTED: _A.SCRIPT},
    _A.SCRIPT: {_E.SCRIPT_ENDED: _A.IDLE},
}
for _row in TRANSITIONS.values():
    _row[_E.PORT_CLOSED] = _A.CLOSED
    _row[_E.CALLED] = _A.CALLING
STAYS = {
    _A.CLOSED: {_E.STOPPED},
    _A.CALLING: {_E.STOPPED},
    _A.IDLE: {_E.STOPPED, _E.RESTED, _E.MODE_ENTERED, _E.MODE_SET, _E.PASSIVE_SET, _E.DEMO_ENDED},
    _A.HOLDING: {
        _E.STOPPED, _E.RESTED, _E.MODE_LEFT, _E.MODE_ENTERED, _E.PASSIVE_SET, _E.DEMO_ENDED},
    _A.DRIVING: {_E.VELOCITY, _E.MODE_ENTERED, _E.MODE_SET, _E.DEMO_ENDED},
    _A.GOAL: {_E.MODE_ENTERED, _E.MODE_SET, _E.DEMO_ENDED},
    _A.DOCKING: {_E.MODE_LEFT, _E.MODE_ENTERED},
    _A.DEMO: {_E.MODE_ENTERED},
    _A.SCRIPT: {_E.STOPPED, _E.MODE_LEFT},
}
"""Events that change nothing in an activity."""


class Then(Enum):
    """What the driver does after an event."""

    STAND = auto()
    """The wheels are to stand."""
    AGAIN = auto()
    """The wheel speeds are sent again, though the robot was sent the same before."""
    CALL_OFF = auto()
    """What waits to be sent and would let the robot move by itself is dropped."""
    FORGET = auto()
    """Nothing is known of the robot, and requests that wait for it fail."""
    END = auto()
    """A goal that runs ends, with the code of the event."""
    GIVE_BACK = auto()
    """The mode from before that goal is wanted again; it is entered when the robot may."""
    RESTORE = auto()
    """The same, and it is entered now."""
    WARN = auto()
    """A velocity that is refused is a warning again."""


STAND, AGAIN, CALL_OFF, FORGET, END, GIVE_BACK, RESTORE, WARN = Then
___ = None
CONSEQUENCES: dict[StateEvent, tuple[Then | None, ...]] = {
    # event              wheels speeds queued    robot   goal mode       warnings
    _E.PORT_CLOSED:     (STAND, ___,   CALL_OFF, FORGET, END, GIVE_BACK, ___),
    _E.CALLED:          (STAND, ___,   CALL_OFF, FORGET, END, GIVE_BACK, ___),
    _E.ANSWERED:        (___,   AGAIN, ___,      ___,    ___, ___,       WARN),
    _E.RETURNED:        (___,   AGAIN, ___,      ___,    ___, ___,       WARN),
    _E.VELOCITY:        (___,   ___,   ___,      ___,    ___, ___,       ___),
    _E.HALTED:          (STAND, ___,   ___,      ___,    ___, ___,       ___),
    _E.STOPPED:         (STAND, AGAIN, CALL_OFF, ___,    END, RESTORE,   ___),
    _E.RESTED:          (STAND, AGAIN, CALL_OFF, ___,    END, ___,       ___),
    _E.MODE_LEFT:       (STAND, AGAIN, CALL_OFF, ___,    END, GIVE_BACK, WARN),
    _E.MODE_ENTERED:    (___,   AGAIN, ___,      ___,    ___, ___,       ___),
    _E.MODE_SET:        (___,   AGAIN, CALL_OFF, ___,    END, ___,       ___),
    _E.PASSIVE_SET:     (STAND, AGAIN, CALL_OFF, ___,    END, ___,       ___),
    _E.DEMO_STARTED:    (STAND, AGAIN, CALL_OFF, ___,    END, ___,       ___),
    _E.DEMO_ENDED:      (___,   AGAIN, CALL_OFF, ___,    END, ___,       ___),
    _E.GOAL_STARTED:    (___,   AGAIN, CALL_OFF, ___,    ___, ___,       ___),
    _E.DOCKING_STARTED: (STAND, AGAIN, ___,      ___,    ___, ___,       ___),
    _E.GOAL_ENDED:      (STAND, AGAIN, CALL_OFF, ___,    ___, RESTORE,   ___),
    _E.SCRIPT_STARTED:  (___,   AGAIN, CALL_OFF, ___,    ___, ___,       ___),
    _E.SCRIPT_ENDED:    (___,   AGAIN, CALL_OFF, ___,    ___, ___,       ___),
}
"""
What follows from each event, from left to right; where it changes no activity, only `AGAIN`.

The mode from before a goal is neither given back nor restored where somebody has just asked for
another: RESTED, MODE_SET, PASSIVE_SET, DEMO_STARTED, DEMO_ENDED.
"""

REFUSALS = {
    _A.CLOSED: f'{_A.CLOSED.value}: check cable and power, the driver keeps trying',
    _A.CALLING: f'{_A.CALLING.value}: check cable and power, the driver keeps trying',
    _A.SCRIPT: ('a script plays, and the robot obeys nothing while it waits, a stop included '
                '(perhaps later): let it end, or switch the robot off by its Power button'),
}
"""Why the robot takes no commands now, and what to do; activities not listed take them."""
DRIVE_REFUSALS = {
    **REFUSALS, _A.DEMO: 'a demo runs: call stop_demo, then set_mode with SAFE',
    _A.DOCKING: 'a goal looks for the dock: cancel it, or call stop'}
"""Why the robot follows no velocity now, and what to do."""


class State:
    """The present activity, and what follows from it."""

    def __init__(self, activity: Activity = Activity.CLOSED) -> None:
        self._enter(activity)

    def handle(self, event: StateEvent) -> tuple[Then, ...] | None:
        """Change the activity as the table says; return what follows, None where none lists it."""
        before = self.activity
        after = TRANSITIONS[before].get(event)
        if after is not None:
            self._enter(after)
            return tuple(filter(None, CONSEQUENCES[event]))
        if event not in STAYS[before]:
            return None
        return (AGAIN,) if AGAIN in CONSEQUENCES[event] else ()

    def _enter(self, activity: Activity) -> None:
        # Worked out once here, since the driver asks many times in every frame.
        self.activity = activity
        self.answered = activity not in (Activity.CLOSED, Activity.CALLING)
        """Whether the robot answers."""
        self.robot_moves = activity in (Activity.DEMO, Activity.DOCKING, Activity.SCRIPT)
        """Whether the robot itself decides how the wheels turn."""
        self.refusal = REFUSALS.get(activity)
        """Why the robot takes no commands now, and what to do; None where it takes them."""
        self.drive_refusal = DRIVE_REFUSALS.get(activity)
        """Why the robot follows no velocity now, and what to do; None where it may."""
        self.takes_commands = self.refusal is None
        """Whether the robot takes commands now."""
        self.moving = activity in (Activity.DRIVING, Activity.GOAL)
        """Whether a commanded velocity, or a goal, makes the wheels turn."""
        self.pursues = activity in (Activity.GOAL, Activity.DOCKING)
        """Whether a goal runs."""
