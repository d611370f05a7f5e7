# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""The speed along one way, frame by frame: faster, slower, stop, settle, correct."""


import pytest

from create_oi_ros import oi
from create_oi_ros.driver import MotionLimits
from create_oi_ros.driver.goals.goal import Instruction, StoppingModel, View
from create_oi_ros.driver.goals.legs import Straight
from create_oi_ros.driver.motion import Velocity
from create_oi_ros.odometry import Estimate

WAY, TOP, DT = 1.0, 0.3, 0.1


def approach(learned: StoppingModel | None = None, way: float = WAY) -> Straight:
    """Return a straight line that has not begun."""
    return Straight(at(WAY)._replace(straight=learned or StoppingModel()), way, 0.0, TOP)


def at(left: float, speed: float = 0.0, dt: float = DT, measured: bool = False) -> View:
    """Return what a frame says."""
    return View(0.0, dt, Estimate(x=WAY - left, linear=speed), oi.Readings(), measured,
                MotionLimits(linear_acceleration=0.0), StoppingModel(), StoppingModel())


def step(begun: Straight, frame: View) -> float | None:
    """Return the speed that a frame leads to: 0 too where it asks for a reading."""
    told = begun.step(frame)
    if isinstance(told, Velocity):
        assert told.angular == 0.0
        return told.linear
    return 0.0 if told is Instruction.MEASURE else None


def stopped(left: float, pace: float = 0.0, learned: StoppingModel | None = None) -> Straight:
    """Return an approach that has just told the wheels to stand, with so much left."""
    begun = approach(learned)
    step(begun, at(1.0))
    assert step(begun, at(left, pace)) == 0.0
    return begun


def frames_until_moving(begun: Straight, frame: View) -> int:
    """Return after how many frames an approach that stands has arrived or goes on."""
    count = 0
    while step(begun, frame) == 0.0 and not begun.correcting:
        count += 1
    return count


@pytest.mark.parametrize(('way', 'coast', 'push'), [(9.0, 0.8, 3.0), (-1.0, 0.03, 0.3)])
def test_a_coast_or_a_push_that_cannot_be_is_not_believed(way, coast, push):
    learned = StoppingModel()
    for _ in range(50):
        learned.stopped(0.3, way)
        learned.pushed(0.01, way / 10)
    assert (learned.coast, learned.push) == pytest.approx((coast, push), abs=0.001)


@pytest.mark.parametrize('sign', [1, -1])
def test_a_short_rest_of_the_way_is_a_push_of_its_length(sign):
    begun = stopped(0.0)
    frames_until_moving(begun, at(sign * 0.015))
    told = [step(begun, at(sign * 0.015, dt=0.01)) for _ in range(60)]
    assert told == 50 * [sign * 0.03] + 10 * [0.0]


def test_it_corrects_three_times_at_most():
    begun, left, corrections, before = stopped(0.0), 0.01, 0, 0.0
    while (speed := step(begun, at(left))) is not None:
        corrections += bool(speed and not before)
        if before and not speed:
            left = -left  # each leads too far
        before = speed
    assert corrections == 3
    assert begun.correcting


@pytest.mark.parametrize(('way', 'sign'), [(0.01, 1), (0.01, -1), (0.1, 1)])
def test_a_correction_that_moves_nothing_is_none_and_the_next_is_faster(way, sign):
    begun, told, before = stopped(0.0), [], 0.0
    left = at(sign * way)
    while (speed := step(begun, left)) is not None:
        if speed and not before:
            told.append(speed)
        before = speed
        # The odometry believes that creeping moves the robot until a reading says otherwise.
        left = at(sign * (0.0 if speed and way > 0.02 else way), sign * 0.03 if speed else 0.0)
    assert told == pytest.approx(
        [sign * speed for speed in (0.03, 0.04, 0.05, 0.06, 0.07, 0.08, 0.08, 0.08)])


@pytest.mark.parametrize('sign', [1, -1])
def test_a_push_that_led_too_far_makes_the_next_one_shorter(sign):
    learned = StoppingModel()
    begun = stopped(0.0, learned=learned)
    frames_until_moving(begun, at(sign * 0.015))
    while step(begun, at(sign * 0.015, dt=0.01)):
        pass
    told = [step(begun, at(-sign * 0.015, dt=0.01, measured=True)) for _ in range(200)]
    assert told.count(-sign * 0.03) == round(50 / learned.push)
    expected = StoppingModel()
    expected.pushed(0.015, 0.03)
    assert learned.push == pytest.approx(expected.push)


def test_how_long_a_way_takes_at_most():
    ramps = 0.15 * (1 / 0.5 + 1 / 0.25)
    settling = 4 * (1.4 + 0.02 / 0.03)
    for way in (1.5, -1.5):
        assert approach(way=way).seconds() == pytest.approx(1.5 / TOP + ramps + settling)


def test_a_robot_that_stands_is_asked_how_far_it_went_until_a_reading_comes():
    begun = approach()
    assert step(begun, at(1.0)) > 0
    assert step(begun, at(0.0)) == 0.0
    told = [begun.step(at(0.0, dt=0.01, measured=frame == 20)) for frame in range(30)]
    assert told == 15 * [Velocity()] + 5 * [Instruction.MEASURE] + 10 * [Velocity()]
