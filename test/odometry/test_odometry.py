"""The laws of odometry: no step, honest covariance, exact where the robot is exact."""

from collections.abc import Iterator
from dataclasses import replace
from math import atan2, cos, degrees, hypot, isfinite, radians, sin, tau

from hypothesis import given, settings
from hypothesis import strategies as st
import pytest

from create_oi_ros.odometry import Estimate, Geometry, Increment, Odometry, Rounding, states
from create_oi_ros.odometry.rounding import cut_normal, interval
from create_oi_ros.sim.body import Body
from create_oi_ros.sim.body.config import BodyConfig, CENTRE, EncoderSign, IDEAL
from create_oi_ros.sim.body.encoders import Accumulator
from create_oi_ros.sim.body.encoders import Rounding as RobotRounding
from create_oi_ros.sim.body.wheels import Response, TimeConstant
from create_oi_ros.sim.world import World

SLOT = 0.015
HALF_TRACK = 0.129
TOP = 0.5
ROUNDINGS = list(RobotRounding)

Request = tuple[float, float, float]
"""Seconds, and the speeds of the right and left wheel."""


LESSON = [(0.3, 0.1), (0.05, -0.05), (-0.2, -0.3), (0.18, 0.18), (-0.1, 0.15), (0.0, 0.0)]


class Ride:
    """A body that an odometry follows: the answer to a question comes in the next frame."""

    def __init__(self, rounding: RobotRounding = RobotRounding.TRUNCATE, *, window: float = 1.0,
                 geometry: Geometry | None = None, frame: int = 1,
                 config: BodyConfig | None = None) -> None:
        self.body = Body(World(), rounding=rounding, config=config or IDEAL)
        self.odometry = Odometry(geometry or Geometry(), window=window)
        self.frame = frame * SLOT
        self.right = self.left = 0.0
        self.driven = True
        self.estimates = [self.odometry.estimate]
        self.origin = self.body.truth()
        self.go(0.1)

    def go(self, seconds: float, right: float = 0.0, left: float = 0.0) -> Estimate:
        """Drive for a while."""
        self.right, self.left = right, left
        if self.driven:
            self.body.drive(right=right, left=left)
        for _ in range(round(seconds / self.frame)):
            self.body.step(self.frame)
            self.hear(self.odometry.reading_due)
        return self.estimates[-1]

    def hear(self, reading: bool, *, lost: bool = False) -> None:
        """Take the next frame in; `lost`: another may have been lost before it."""
        self.estimates.append(self.odometry.update(Increment(
            dt=self.frame, right=self.right, left=self.left, driven=self.driven, lost=lost,
            distance=self.body.take_distance() if reading else None,
            angle=self.body.take_angle() if reading else None)))

    def learn(self) -> None:
        """Drive until the odometry knows the robot."""
        for right, left in LESSON * 2:
            self.go(2.5, right, left)
        self.go(2)

    def begin(self) -> None:
        """Measure from here: the origin of the odometry is put where the robot is."""
        self.go(2)
        self.odometry.reset()
        self.origin = self.body.truth()

    @property
    def went(self) -> tuple[float, float]:
        """How far the robot has gone and turned since it began, m and rad."""
        truth = self.body.truth()
        return truth.travelled - self.origin.travelled, truth.turned - self.origin.turned

    @property
    def miss(self) -> tuple[float, float]:
        """How far off the estimate is, m and degrees."""
        (x, y, yaw), truth = self.origin.pose, self.body.truth()
        estimate = self.odometry.estimate
        east, north = truth.pose.x - x, truth.pose.y - y
        return (hypot(estimate.x - east * cos(yaw) - north * sin(yaw),
                      estimate.y - north * cos(yaw) + east * sin(yaw)),
                abs(degrees(estimate.yaw - truth.turned + self.origin.turned)))


def assert_smooth(estimates: list[Estimate], frame: float = SLOT) -> None:
    """No step is larger than what the robot can have moved, 1 mm and 0.2 degrees."""
    reach = TOP * 1.03 * frame
    for a, b in zip(estimates, estimates[1:]):
        assert hypot(b.x - a.x, b.y - a.y) <= reach + 1e-3
        assert abs(b.yaw - a.yaw) <= reach / HALF_TRACK + radians(0.2)


def assert_sound(estimate: Estimate) -> None:
    """Everything is finite, the covariance symmetric and positive definite."""
    a, b, c, d, e, f, g, h, i = estimate.pose_covariance
    assert all(map(isfinite, estimate.pose_covariance + estimate.twist_covariance))
    assert all(map(isfinite, (estimate.x, estimate.y, estimate.yaw, estimate.linear,
                              estimate.angular, estimate.right_wheel, estimate.left_wheel)))
    assert (b, c, f) == (d, g, h)
    assert a > 0 and a * e - b * b > 0
    assert a * (e * i - f * f) - b * (b * i - c * f) + c * (b * f - c * e) > 0
    assert min(estimate.twist_covariance) > 0


WHEEL = st.integers(-500, 500).map(lambda mm: mm / 1000)
REQUESTS = st.lists(st.tuples(st.sampled_from((0.03, 0.3, 1.5)), WHEEL, WHEEL), max_size=12)


@given(REQUESTS, st.sampled_from(ROUNDINGS), st.sampled_from((0.25, 1.0, 3.0)))
@settings(max_examples=40, deadline=None)
def test_never_jumps_and_always_knows_how_sure_it_is(
        requests: list[Request], rounding: RobotRounding, window: float) -> None:
    ride = Ride(rounding, window=window)
    for seconds, right, left in requests:
        ride.go(seconds, right, left)
    assert_smooth(ride.estimates)
    for estimate in ride.estimates:
        assert_sound(estimate)


READINGS = st.none() | st.tuples(st.integers(-32768, 32767), st.integers(-32768, 32767))
FRAMES = st.lists(st.tuples(
    st.sampled_from((1, 1, 1, 2, 50)), WHEEL, WHEEL, st.booleans(), st.booleans(), READINGS,
    st.sampled_from(('', '', '', 'interrupted', 'reset'))), max_size=60)


@given(FRAMES, st.sampled_from((0.0, 1.0)))
@settings(max_examples=60, deadline=None)
def test_survives_whatever_a_robot_may_say(frames: list, window: float) -> None:
    odometry = Odometry(window=window)
    for slots, right, left, driven, lifted, reading, event in frames:
        if event:
            getattr(odometry, event)()
        before = odometry.estimate
        distance, angle = reading or (None, None)
        after = odometry.update(Increment(
            dt=slots * SLOT, right=right, left=left, driven=driven, lifted=lifted,
            distance=distance, angle=angle))
        assert_sound(after)
        if window:
            assert_smooth([before, after], slots * SLOT)


@pytest.mark.parametrize('rounding', ROUNDINGS)
@pytest.mark.parametrize(('speed', 'seconds'), [(0.02, 60), (0.2, 20), (-0.2, 20), (0.5, 10)])
def test_a_straight_line_is_exact(rounding: RobotRounding, speed: float, seconds: float) -> None:
    """As far as the numbers can tell: at 200 mm/s and even slots nothing is ever dropped."""
    ride = Ride(rounding)
    ride.go(seconds, speed, speed)
    ride.go(3)
    assert ride.miss[0] < 3e-3 + 0.003 * abs(speed * seconds)
    assert ride.miss[1] < 0.3


@pytest.mark.parametrize('rounding', ROUNDINGS)
@pytest.mark.parametrize(
    ('right', 'left'), [(0.213, 0.146), (0.097, -0.103), (0.014, -0.014), (-0.31, -0.197)])
def test_a_circle_is_exact(rounding: RobotRounding, right: float, left: float) -> None:
    ride = Ride(rounding)
    ride.learn()
    ride.begin()
    ride.go(60, right, left)
    ride.go(3)
    far, turned = ride.went
    assert ride.miss[1] < 2 + 0.6 * abs(turned) / tau
    assert ride.miss[0] < 0.01 + 0.02 * abs(far)


def test_slow_turns_register() -> None:
    """Read in every frame, a robot that truncates never reports a turn of 10 degrees a second."""
    plain, ours = Ride(window=0.0), Ride()
    for ride in (plain, ours):
        ride.go(20, 0.0225, -0.0225)
        ride.go(3)
    assert plain.miss[1] > 190
    assert ours.miss[1] < 2


@pytest.mark.parametrize('rounding', ROUNDINGS)
def test_finds_out_rounding_gains_and_acceleration(rounding: RobotRounding) -> None:
    ride = Ride(rounding, config=replace(IDEAL,
        wheel_acceleration=0.7, right_speed_gain=1.02, left_speed_gain=0.98))
    for right, left in [(0.3, 0.1), (0.05, -0.05), (-0.2, -0.3), (0.18, 0.18), (0.0, 0.0)] * 4:
        ride.go(2.5, right, left)
    tracks = ride.odometry.tracks
    assert tracks.rows.roundings[0] is Rounding(rounding.value)
    assert 1 / tracks.rows.means[0, states.RAMP] == pytest.approx(0.7, rel=0.03)
    assert tracks.goals(0.2, 0.2) == pytest.approx((0.204, 0.196), abs=0.0006)


@pytest.mark.parametrize('rounding', ROUNDINGS)
def test_a_mixed_drive_stays_close(rounding: RobotRounding) -> None:
    ride = Ride(rounding, config=replace(IDEAL, right_speed_gain=1.03, left_speed_gain=0.98))
    for right, left in [(0.3, 0.2), (0.1, -0.1), (0.0, 0.0), (-0.2, -0.15), (0.45, 0.5)] * 5:
        ride.go(2.1, right, left)
    ride.go(3)
    assert ride.miss[1] < 6  # of more than 1800
    assert ride.miss[0] < 0.25  # of 12 m


REVERSALS = [(0.3, 0.2), (0.1, -0.1), (0.0, 0.0), (-0.2, -0.15), (-0.2, 0.2), (0.25, 0.3)]


@pytest.mark.parametrize('rounding', ROUNDINGS)
@pytest.mark.parametrize(('config', 'most'), [
    (CENTRE, 10),
    (replace(CENTRE, encoder_sign=EncoderSign.TRUE, response=Response.RAMP, braking=2.0), 10),
    (replace(CENTRE, encoder_sign=EncoderSign.COMMAND, dead_time=0.12, right_speed_gain=0.96), 10),
    (replace(CENTRE, response=Response.SECOND_ORDER, time_constant=TimeConstant(0.05),
             overshoot=0.3, dead_time=0.1), 25)],
    ids=['the centre', 'true signs, hard brakes', 'signs of the command', 'overshoot'])
def test_any_wheels_are_followed(
        config: BodyConfig, most: float, rounding: RobotRounding) -> None:
    """Also those that no track describes, as ones that overshoot: yaw does not run away."""
    ride = Ride(rounding, config=config)
    for right, left in REVERSALS * 7:
        ride.go(2.1, right, left)
    ride.go(3)
    assert ride.miss[1] < most  # of some 2600
    assert ride.miss[0] < 0.4  # of 14 m


def test_a_reversal_just_before_a_reading_is_no_disobedience() -> None:
    ride = Ride(config=replace(IDEAL, wheel_acceleration=1.0))
    ride.learn()
    for right in (0.4, -0.4) * 6:
        while not ride.odometry.reading_due:
            ride.go(SLOT, right, -right)
        for _ in range(60):
            ride.go(SLOT, -right, right)
            assert not ride.odometry.tracks.is_free


def test_yaw_is_never_corrected_by_more_than_five_degrees_in_half_a_second() -> None:
    ride = Ride(config=CENTRE)
    for right, left in REVERSALS * 3:
        ride.go(2.1, right, left)
    corrections = [b.yaw - a.yaw - b.angular * SLOT
                   for a, b in zip(ride.estimates, ride.estimates[1:])]
    half = round(0.5 / SLOT)
    assert max(abs(sum(corrections[i:i + half])) for i in range(len(corrections))) < radians(5)


@pytest.mark.parametrize('frame', [2, 3])
def test_cutting_the_same_motion_into_other_frames_changes_nothing(frame: int) -> None:
    fine, coarse = Ride(), Ride(frame=frame)
    for ride in (fine, coarse):
        ride.go(6, 0.3, 0.2)
        ride.go(3)
    a, b = fine.estimates[-1], coarse.estimates[-1]
    assert (a.x, a.y) == pytest.approx((b.x, b.y), abs=0.03)  # of 1.5 m
    assert a.yaw == pytest.approx(b.yaw, abs=radians(3))  # of 133 degrees


@given(st.lists(st.integers(1, 40), min_size=1, max_size=20))
@settings(max_examples=30, deadline=None)
def test_prediction_does_not_depend_on_how_time_is_cut(cuts: list[int]) -> None:
    whole, cut = Odometry(window=1e6), Odometry(window=1e6)
    for odometry in (whole, cut):
        odometry.update(Increment(dt=SLOT, right=0.4, left=0.1, driven=True))
        # The rest begins with both wheels at their goals and corrections blended in.
        for _ in range(200):
            odometry.update(Increment(dt=SLOT, right=0.4, left=0.1, driven=True))
    for slots in cuts:
        cut.update(Increment(dt=slots * SLOT, right=0.4, left=0.1, driven=True))
    for _ in range(sum(cuts)):
        whole.update(Increment(dt=SLOT, right=0.4, left=0.1, driven=True))
    a, b = whole.estimate, cut.estimate
    assert (a.x, a.y, a.yaw) == pytest.approx((b.x, b.y, b.yaw), abs=1e-4)


def test_rest_costs_no_certainty_and_motion_does() -> None:
    ride = Ride()
    ride.go(5, 0.2, 0.1)
    moved = ride.go(5).pose_covariance
    rested = ride.go(60).pose_covariance
    assert all(rested[i] < 1.001 * moved[i] + 1e-8 for i in (0, 4, 8))  # readings still teach
    assert ride.go(300, 0.2, 0.1).pose_covariance[8] > rested[8]


def test_velocities_are_those_of_the_robot() -> None:
    ride = Ride(config=replace(IDEAL, right_speed_gain=0.97, left_speed_gain=0.97))
    for _ in range(4):
        ride.go(5, 0.2, 0.2)
        ride.go(2, -0.1, 0.1)
    estimate = ride.go(5, 0.2, 0.2)
    assert estimate.linear == pytest.approx(0.194, abs=0.001)
    assert estimate.angular == pytest.approx(0.0, abs=0.01)


def test_wheels_turn_as_the_base_moves() -> None:
    geometry = Geometry()
    ride = Ride(geometry=geometry)
    ride.learn()
    begun, before = ride.estimates[-1], ride.body.truth().travelled
    estimate = ride.go(10, 0.2, 0.1)
    right = (estimate.right_wheel - begun.right_wheel) * geometry.wheel_radius
    left = (estimate.left_wheel - begun.left_wheel) * geometry.wheel_radius
    assert (right - left) / geometry.wheel_separation == pytest.approx(
        estimate.yaw - begun.yaw, abs=1e-6)
    assert (right + left) / 2 == pytest.approx(ride.body.truth().travelled - before, abs=0.005)
    assert estimate.right_wheel_speed * geometry.wheel_radius == pytest.approx(0.2, abs=0.005)
    assert estimate.left_wheel_speed * geometry.wheel_radius == pytest.approx(0.1, abs=0.005)


def test_scales_that_calibration_found_are_applied() -> None:
    config = replace(IDEAL, right_wheel_scale=1.05, left_wheel_scale=1.05)
    ride = Ride(config=config, geometry=Geometry(linear_scale=1.05, angular_scale=1.05))
    ride.go(20, 0.2, 0.15)
    ride.go(3)
    assert ride.miss[0] < 0.05
    assert ride.miss[1] < 1.5


def test_reset_begins_at_the_origin_and_keeps_what_was_learned() -> None:
    ride = Ride(RobotRounding.ROUND)
    for right, left in [(0.3, 0.1), (0.05, -0.05), (-0.2, -0.3), (0.0, 0.0)] * 4:
        ride.go(2.5, right, left)
    learned = ride.odometry.tracks.rows.roundings[0]
    wheel = ride.estimates[-1].right_wheel
    ride.odometry.reset()
    estimate = ride.odometry.estimate
    assert (estimate.x, estimate.y, estimate.yaw) == (0.0, 0.0, 0.0)
    assert estimate.right_wheel == wheel
    assert ride.odometry.tracks.rows.roundings[0] is learned
    before = ride.body.truth()
    estimate = ride.go(5, 0.2, 0.2)
    after = ride.body.truth()
    assert estimate.x == pytest.approx(after.travelled - before.travelled, abs=0.005)
    assert estimate.y == pytest.approx(0.0, abs=0.005)


def test_after_an_interruption_it_goes_on_from_where_it_was_without_a_jump() -> None:
    ride = Ride()
    ride.go(5, 0.2, 0.2)
    ride.odometry.interrupted()
    ride.body.step(2.0)
    ride.go(8, 0.2, 0.2)
    ride.go(3)
    assert_smooth(ride.estimates)
    assert ride.miss[0] < 0.05


def test_an_interruption_in_which_the_robot_moved_unseen_leaves_doubt() -> None:
    ride = Ride()
    ride.learn()
    ride.odometry.reset()
    ride.go(5, 0.2, 0.2)
    before = ride.estimates[-1].pose_covariance
    ride.odometry.interrupted()
    ride.body.push(speed=0.2, rate=1.0, seconds=3.0)
    ride.body.step(3.0)
    after = ride.go(3).pose_covariance
    assert after[0] + after[4] > 10 * (before[0] + before[4])


def test_the_first_reading_may_hold_travel_from_before() -> None:
    body = Body(World())
    body.drive(right=0.3, left=0.3)
    body.step(10.0)
    odometry = Odometry(window=1.0)
    odometry.update(Increment(dt=SLOT, right=0.0, left=0.0, driven=True,
                              distance=body.take_distance(), angle=body.take_angle()))
    assert (odometry.estimate.x, odometry.estimate.yaw) == (0.0, 0.0)


def test_a_held_robot_is_believed_to_stand() -> None:
    ride = Ride()
    ride.go(20, 0.2, 0.2)
    ride.body.hold(right=True, left=True)
    held = ride.body.truth().travelled
    estimate = ride.go(10, 0.2, 0.2)
    assert estimate.x == pytest.approx(held, abs=0.02)
    assert abs(estimate.linear) < 0.02
    ride.body.hold(right=False, left=False)
    ride.go(10, 0.2, 0.2)
    assert ride.miss[0] < 0.03
    assert_smooth(ride.estimates)


def test_a_pushed_robot_is_followed() -> None:
    ride = Ride()
    ride.go(20, 0.18, 0.16)
    ride.driven = False
    ride.body.drive(right=0.0, left=0.0)
    ride.go(3)
    ride.body.push(speed=0.2, rate=0.1, seconds=5.0)
    ride.go(9)
    assert ride.miss[0] < 0.1
    assert ride.miss[1] < 5
    assert_smooth(ride.estimates)


def test_a_lifted_robot_goes_nowhere() -> None:
    odometry = Odometry(window=1.0)
    for frame in range(200):
        estimate = odometry.update(Increment(
            dt=SLOT, right=0.3, left=0.2, driven=True, lifted=True,
            distance=300 if frame % 66 == 65 else None, angle=20 if frame % 66 == 65 else None))
    assert hypot(estimate.x, estimate.y) < 0.01


def test_a_reading_that_was_lost_on_the_line_does_not_take_travel_back() -> None:
    ride = Ride()
    ride.go(20, 0.3, 0.25)
    while not ride.odometry.reading_due:
        ride.go(SLOT, 0.3, 0.25)
    ride.body.step(SLOT)
    ride.body.take_distance(), ride.body.take_angle()
    ride.hear(False, lost=True)
    ride.go(5, 0.3, 0.25)
    ride.go(3)
    assert ride.miss[0] < 0.08
    assert ride.miss[1] < 3


def test_a_held_robot_is_not_taken_for_one_whose_reading_was_lost() -> None:
    """No frame is missing; the line was just too slow for the question."""
    ride = Ride()
    ride.go(20, 0.2, 0.2)
    while not ride.odometry.reading_due:
        ride.go(SLOT, 0.2, 0.2)
    ride.go(SLOT, 0.2, 0.2)
    ride.body.hold(right=True, left=True)
    for speed, frames in ((0.2, 70), (0.0, 70)):
        ride.right = ride.left = speed
        for _ in range(frames):
            ride.body.step(SLOT)
            ride.hear(False)
    ride.go(3)
    assert ride.miss[0] < 0.02
    assert_smooth(ride.estimates)


def asked(odometry: Odometry, frames: int) -> Iterator[bool]:
    """Yield after every frame at rest whether a reading is due; none ever comes."""
    for _ in range(frames):
        odometry.update(Increment(dt=SLOT, right=0.0, left=0.0, driven=True))
        yield odometry.reading_due


def test_asks_once_a_window_for_one_frame_and_again_when_no_answer_comes() -> None:
    ride = Ride()
    ride.go(5)
    questions = []
    for _ in range(400):
        ride.go(SLOT)
        questions.append(ride.odometry.reading_due)
    assert 3 <= sum(questions) <= 12
    assert not any(a and b for a, b in zip(questions, questions[1:]))
    assert sum(asked(Odometry(window=1.0), 200)) > 10


def test_without_a_window_it_asks_in_every_frame_and_believes_the_robot() -> None:
    odometry = Odometry(window=0.0)
    assert all(asked(odometry, 5))
    for _ in range(11):
        estimate = odometry.update(Increment(
            dt=SLOT, right=0.4, left=0.4, driven=True, distance=6, angle=0))
    assert estimate.x == pytest.approx(0.060)  # the first reading is discarded
    assert estimate.linear == pytest.approx(0.4)


def test_heading_and_course_agree() -> None:
    ride = Ride()
    ride.go(5, 0.2, 0.2)
    ride.go(2, 0.1, -0.1)
    a = ride.go(3, 0.2, 0.2)
    b = ride.go(2, 0.2, 0.2)
    course = atan2(b.y - a.y, b.x - a.x)
    assert cos(course - b.yaw) > cos(radians(2))
    assert abs(sin(course - b.yaw)) < sin(radians(2))


@given(st.floats(-60, 60), st.floats(1e-4, 50))
def test_what_is_cut_from_a_normal_lies_inside_the_cut(low: float, width: float) -> None:
    mean, variance, mass = cut_normal(low, low + width)
    slack = 1e-6 * (1 + abs(low))
    assert low - slack <= mean <= low + width + slack
    assert 0 < variance <= min(1.0, width * width / 12 * 1.01) + 1e-9
    assert 0 <= mass <= 1


@pytest.mark.parametrize(('low', 'high', 'mean', 'variance', 'mass'), [
    (-1.0, 1.0, 0.0, 0.291125, 0.682689), (2.0, 3.0, 2.315819, 0.06152, 0.0214),
    (-9.0, -8.0, -8.1212, 0.01415, 6.2e-16), (-50.0, 50.0, 0.0, 1.0, 1.0)])
def test_moments_of_a_cut_normal(
        low: float, high: float, mean: float, variance: float, mass: float) -> None:
    """The expected values were integrated numerically."""
    found = cut_normal(low, high)
    assert found[0] == pytest.approx(mean, abs=0.005)
    assert found[1] == pytest.approx(variance, abs=0.002)
    assert found[2] == pytest.approx(mass, rel=0.02)


@given(st.floats(-50, 50), st.sampled_from(ROUNDINGS))
def test_an_interval_holds_whatever_rounds_to_its_number(
        amount: float, rounding: RobotRounding) -> None:
    accumulator = Accumulator(rounding)
    accumulator.add(amount)
    low, high = interval(Rounding(rounding.value), accumulator.take())
    assert low - 1e-5 <= amount <= high + 1e-5


def test_roundings_are_those_of_the_robot() -> None:
    assert {each.value for each in Rounding} == {each.value for each in RobotRounding}
