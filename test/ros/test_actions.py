# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Every action as a user sees it: through ROS, with the node as a process."""

from math import inf, nan, pi
from re import fullmatch
import signal

from action_msgs.msg import GoalStatus
from builtin_interfaces.msg import Duration
from create_oi_msgs.action import (
    AudioNoteSequence,
    Dock,
    DriveArc,
    DriveDistance,
    NavigateToPosition,
    RotateAngle,
    Undock,
)
from create_oi_msgs.msg import Mode
from create_oi_msgs.srv import DefineSong, SetDigitalOutput
from geometry_msgs.msg import Point, Pose, PoseStamped
import pytest
from std_msgs.msg import Header
from std_srvs.srv import Trigger

from create_oi_ros.driver.goals import Code
from create_oi_ros.ros.actions import malformed
from create_oi_ros.ros.messages import filled
from create_oi_ros.sim.world import parse
from support.ros import Program, Ready, Sent

TUNE = (AudioNoteSequence, 'audio_note_sequence')
BASE = parse('start 0.4 0 180\nhome_base 0 0 0', 'base')


def moving(ready: Ready, **fields: object) -> Sent:
    """Start a long drive, and wait until the robot moves."""
    sent = ready.ros.send(DriveDistance, 'drive_distance', distance=3.0, **fields)
    # Feedback tells that it is this drive, not the end of the one before.
    ready.ros.until(lambda: sent.feedback and ready.robot.body.truth().speed > 0.05, 'it moves')
    return sent


def test_motions_are_done_with_feedback_and_a_pose(ready):
    sent = ready.ros.send(DriveDistance, 'drive_distance', distance=0.3)
    result = sent.result()
    assert (sent.status, result.success, result.error_code) == (
        GoalStatus.STATUS_SUCCEEDED, True, DriveDistance.Result.NONE)
    assert result.message.startswith('drove 0.')
    assert result.pose.header.frame_id == 'odom'
    assert result.pose.header.stamp.sec > 0
    assert result.pose.pose.position.x == pytest.approx(0.3, abs=0.01)
    assert ready.robot.body.truth().pose.x == pytest.approx(0.3, abs=0.01)
    left = [each.remaining_travel_distance for each in sent.feedback]
    assert len(left) > 5 and left[0] > 0.2 > left[-1] >= 0
    sent = ready.ros.send(RotateAngle, 'rotate_angle', angle=pi / 2)
    assert sent.result().success
    assert ready.robot.body.truth().pose.yaw == pytest.approx(pi / 2, abs=0.03)
    assert sent.feedback[0].remaining_angle_travel > 1
    sent = ready.ros.send(DriveArc, 'drive_arc', angle=-pi / 2, radius=0.2,
                          translate_direction=DriveArc.Goal.TRANSLATE_FORWARD)
    assert sent.result().success
    pose = ready.robot.body.truth().pose
    assert (pose.x, pose.y) == pytest.approx((0.5, 0.2), abs=0.03)
    assert sent.feedback[0].remaining_angle_travel > 1


def test_a_place_in_the_odometry_frame_is_reached(ready):
    goal = PoseStamped(header=Header(frame_id='odom'),
                       pose=Pose(position=Point(x=0.3, y=0.3)))
    sent = ready.ros.send(NavigateToPosition, 'navigate_to_position', goal_pose=goal,
                          achieve_goal_heading=True)
    assert sent.result().success
    pose = ready.robot.body.truth().pose
    assert (pose.x, pose.y, pose.yaw) == pytest.approx((0.3, 0.3, 0.0), abs=0.04)
    feedback = NavigateToPosition.Feedback
    assert list(dict.fromkeys(filter(None, (each.navigate_state for each in sent.feedback)))) == [
        feedback.ROTATING_TO_GOAL_POSITION, feedback.DRIVING_TO_GOAL_POSITION,
        feedback.ROTATING_TO_GOAL_ORIENTATION]


def test_the_robot_drives_to_a_place_that_is_published(ready):
    places = ready.ros.node.create_publisher(PoseStamped, 'goal_pose', 1)
    ready.ros.until(places.get_subscription_count, 'goal_pose')
    places.publish(PoseStamped(header=Header(frame_id='map')))
    ready.ros.until(lambda: "goal_pose rejected: goal_pose is in frame 'map'"
                    in ready.node.output, 'a rejection')
    places.publish(PoseStamped(
        header=Header(frame_id='odom'), pose=Pose(position=Point(x=0.1))))
    ready.ros.until(lambda: 'goal_pose: at x 0.' in ready.node.output, 'the end')
    pose = ready.robot.body.truth().pose
    assert (pose.x, pose.y, pose.yaw) == pytest.approx((0.1, 0.0, 0.0), abs=0.04)


@pytest.mark.parametrize(('type_', 'name', 'fields', 'says'), [
    (DriveDistance, 'drive_distance', {'distance': nan}, 'distance = nan m is not finite'),
    (DriveDistance, 'drive_distance', {'distance': 1.0, 'time_allowance': Duration(sec=-1)},
     'time_allowance = -1 s'),
    (DriveDistance, 'drive_distance', {'distance': 5000.0},
     'distance = 5000 m; allowed: -1000 to 1000'),
    (DriveDistance, 'drive_distance', {'distance': 1.0, 'max_translation_speed': 4e-4},
     'max_translation_speed = 0.0004 m/s; allowed: 0.001 or more'),
    (RotateAngle, 'rotate_angle', {'angle': inf}, 'angle = inf rad is not finite'),
    (RotateAngle, 'rotate_angle', {'angle': 20000.0}, 'angle = 20000 rad; allowed: -6283.19 to'),
    (RotateAngle, 'rotate_angle', {'angle': 1.0, 'max_rotation_speed': 0.0077},
     'max_rotation_speed = 0.0077 rad/s; allowed: 0.008 or more'),
    (DriveArc, 'drive_arc', {'angle': 1.0, 'radius': 1.0, 'translate_direction': 0},
     'translate_direction = 0; allowed: 1 forward'),
    (DriveArc, 'drive_arc', {'angle': 2.0, 'radius': 1000.0, 'translate_direction': 1},
     'length of the arc = 2000 m; allowed: -1000 to 1000'),
    (DriveArc, 'drive_arc', {'angle': 1.0, 'radius': 0.0, 'translate_direction': 1},
     'radius = 0 m; allowed: above 0'),
    (NavigateToPosition, 'navigate_to_position',
     {'goal_pose': PoseStamped(header=Header(frame_id='map'))},
     "goal_pose is in frame 'map'; allowed: 'odom'"),
    (NavigateToPosition, 'navigate_to_position', {'goal_pose': PoseStamped(
        header=Header(frame_id='odom'), pose=Pose(position=Point(y=1e7)))},
     'goal_pose.position.y = 1e+07 m; allowed'),
    (*TUNE, {'notes': 'C4:99'}, "'C4:99' lasts 99 s; allowed: 1/64 to 60 s"),
    (*TUNE, {'notes': ''}, 'a tune needs a note, such as C4:1/4'),
    (*TUNE, {'notes': 'C4:1', 'iterations': 0}, 'iterations = 0; allowed: above 0, or -1'),
], ids=lambda value: value if isinstance(value, str) else '')
def test_a_malformed_goal_is_rejected_and_the_log_says_why(shared, type_, name, fields, says):
    assert shared.ros.send(type_, name, **fields) is None
    shared.ros.until(lambda: f'{name} rejected: {says}' in shared.node.output, says)
    assert shared.robot.standing
    if type_ is not NavigateToPosition:  # its frame is the driver's
        assert says in malformed(name, type_.Goal(**fields))


def test_a_megabyte_that_somebody_sent_is_not_repeated(shared):
    whole, said = 'x' * 10 ** 6, len(shared.node.output)
    place = PoseStamped(header=Header(frame_id=whole))
    assert shared.ros.send(NavigateToPosition, 'navigate_to_position', goal_pose=place) is None
    assert shared.ros.send(*TUNE, notes=f'C4:1 {whole}') is None
    shared.ros.until(lambda: 'such as C4:1/4, C4:0.25' in shared.node.output[said:])
    assert len(shared.node.output) < said + 3000
    message = shared.refused(SetDigitalOutput, 'set_digital_output', output=whole)
    assert message.endswith('; output_names: output_0, output_1, output_2')
    assert len(message) < 1100


def test_a_goal_takes_over_a_stop_ends_it_and_a_person_at_the_joystick_wins(ready):
    first = moving(ready)
    second = ready.ros.send(RotateAngle, 'rotate_angle', angle=30.0)
    result = first.result()
    assert (first.status, result.error_code) == (
        GoalStatus.STATUS_ABORTED, DriveDistance.Result.SUPERSEDED)
    assert 'another goal' in result.message
    ready.ros.call(Trigger, 'stop')
    assert second.result().error_code == RotateAngle.Result.STOPPED
    ready.ros.until(lambda: ready.robot.standing, 'the wheels are told to stand')
    third = moving(ready)
    ready.ros.drive(-0.1, 0.0, lambda: ready.robot.body.truth().speed < 0)
    result = third.result()
    assert result.error_code == DriveDistance.Result.SUPERSEDED
    assert 'velocity command' in result.message


def test_a_robot_docks_and_leaves_its_dock(stage):
    ready = Ready(stage, world=BASE)
    sent = ready.ros.send(Dock, 'dock')
    result = sent.result()
    assert result.success and result.is_docked, result.message
    seen = [each for each in sent.feedback if each.sees_dock]
    assert any(each.red_buoy or each.green_buoy for each in seen)
    assert {each.state for each in sent.feedback} >= {Dock.Feedback.SEES_DOCK}
    result = ready.ros.send(Undock, 'undock').result()
    assert result.success and not result.is_docked, result.message
    assert 'by FULL' in result.message
    ready.until_mode(Mode.SAFE)
    assert ready.ros.send(Undock, 'undock').result().error_code == Undock.Result.NO_DOCK


CLIENT = """
from create_oi_msgs.action import DriveDistance
import rclpy
from rclpy.action import ActionClient

rclpy.init()
node = rclpy.create_node('brief')
client = ActionClient(node, DriveDistance, 'drive_distance')
client.wait_for_server()
sent = client.send_goal_async(DriveDistance.Goal(distance=5.0))
rclpy.spin_until_future_complete(node, sent)
print('accepted', sent.result().accepted, flush=True)
rclpy.spin(node)
"""


def test_a_goal_ends_when_its_client_the_robot_or_the_driver_has_gone(stage):
    # Of a shared robot, another client would still be there.
    ready = Ready(stage)
    client = stage.python('-c', CLIENT)
    ready.ros.until(lambda: 'accepted True' in client.output, 'the goal is accepted')
    ready.ros.until(lambda: ready.robot.body.truth().speed > 0.1, 'the robot moves')
    client.send(signal.SIGINT)
    ready.ros.until(lambda: ready.robot.standing, 'the wheels stand')
    assert ready.robot.body.truth().travelled < 4.0
    sent = moving(ready)
    ready.robot.unplug()
    assert sent.result().error_code == Code.LINK
    ready.until_mode(Mode.UNKNOWN)
    ready.robot.plug()
    ready.until_mode(Mode.SAFE)
    sent = moving(ready)
    ready.node.send(signal.SIGINT)
    result = sent.result()
    assert result.error_code == Code.LINK
    assert 'the driver ends' in result.message


# Actions that move no wheel.


RING_TONE = f'scale:d=16,o=5,b=180:{",".join(4 * "c c# d d# e f f# g g# a a#".split())},2b'
"""44 notes of a twelfth of a second, and one of two thirds, which a busy computer tells of."""


def test_a_long_tune_is_played_while_the_robot_drives(ready):
    tune = ready.ros.send(*TUNE, notes=RING_TONE)
    drive = ready.ros.send(DriveDistance, 'drive_distance', distance=0.1)
    assert drive.result().success
    assert tune.result().success, tune.result().message
    assert tune.status == GoalStatus.STATUS_SUCCEEDED
    result, told = tune.result(), tune.feedback
    assert (result.iterations_played, result.message) == (1, 'the tune was played')
    ready.ros.until(lambda: told[-1].place == 44)
    assert [each.place for each in told] == sorted({each.place for each in told})
    assert (told[0].note, told[0].place) == ('C5', 0)
    seconds = result.runtime.sec + result.runtime.nanosec / 1e9
    assert 44 / 12 + 2 / 3 - 0.1 < seconds < 44 / 12 + 2 / 3 + 2


def test_a_tune_is_canceled(ready):
    tune = ready.ros.send(*TUNE, notes='60:1/8 rest:1/8',
                          iterations=AudioNoteSequence.Goal.INFINITE)
    ready.ros.until(lambda: tune.feedback and tune.feedback[-1].iterations_played > 1, 'rounds')
    assert {each.note for each in tune.feedback} == {'C4', 'rest'}
    other = ready.ros.send(*TUNE, notes='C4:1')
    assert 'a tune plays: cancel its goal' in other.result().message
    assert tune.cancel()
    assert 'canceled; the song that plays goes on' in tune.result().message
    assert tune.status == GoalStatus.STATUS_CANCELED


# Goals for programs of a few lines, and the example that drives a square by them.


FAILS = """
from create_oi_ros.ros.goal_client import GoalClient, GoalFailed

with GoalClient() as robot:
    for name, goal in (('fly', {}), ('drive_distance', {'distance': 5000.0}),
                       ('undock', {})):
        try:
            robot.do(name, **goal)
        except GoalFailed as why:
            print(why, flush=True)
    print(robot.do('drive_distance', distance=0.05).success, flush=True)
"""

ALONE = """
from create_oi_ros.ros import goal_client

goal_client.DISCOVERY_TIMEOUT = 3.0
with goal_client.GoalClient() as robot:
    try:
        robot.do('drive_distance', distance=0.3)
    except Exception as why:
        print(f'{type(why).__name__}: {why}', flush=True)
"""
"""As a user writes it; no driver is looked for as long as on a busy computer."""


def test_whole_numbers_are_taken_for_floats_also_inside_a_message():
    assert filled(DriveDistance.Goal(check_fields=True), {'distance': 1}, 'x').distance == 1.0
    there = PoseStamped(check_fields=False)
    there.pose.position = Point(check_fields=False)
    there.pose.position.x = 1
    goal = filled(NavigateToPosition.Goal(check_fields=True), {'goal_pose': there}, 'x')
    assert isinstance(goal.goal_pose.pose.position.x, float)
    assert goal.goal_pose.pose.position.x == 1.0


def test_whole_numbers_are_taken_for_floats_also_in_a_list():
    song = filled(DefineSong.Request(check_fields=True),
                  {'pitches': (60, 64), 'seconds': [1, 0.5]}, 'x')
    assert (list(song.pitches), list(song.seconds)) == ([60, 64], [1.0, 0.5])
    for wrong in ([True, 0.5], ['a'], 1, [10 ** 400]):
        with pytest.raises(ValueError, match='allowed is a value of type sequence<float>'):
            filled(DefineSong.Request(check_fields=True), {'seconds': wrong}, 'x')


@pytest.mark.parametrize(('fields', 'words'), [
    ({'dist': 0.1}, "drive_distance has no field 'dist'; allowed: distance, max_trans"),
    ({'distance': '0.1'}, "distance = '0.1'; allowed is a value of type float"),
    ({'distance': True}, 'distance = True; allowed is a value of type float'),
    ({'distance': 1e40}, 'type float'),
    ({'time_allowance': 10}, 'time_allowance = 10; .* type builtin_interfaces/Duration'),
])
def test_a_field_that_does_not_exist_or_fit_is_refused(fields, words):
    with pytest.raises(ValueError, match=words):
        filled(DriveDistance.Goal(check_fields=True), fields, 'drive_distance')


def said(program: Program) -> list[str]:
    """Return the lines of a program but for what it waits for, as on a busy computer."""
    return [line for line in program.printed if ': waits for ' not in line]


def test_the_example_drives_and_turns_until_ctrl_c_cancels_its_goal(ready):
    pose = ready.robot.body.truth

    def begun():
        """Start it; return it after a side and a corner, None where the computer stood still."""
        ready.renew()
        before, started = len(ready.node.output), ready.stage.example('square.py')
        ready.ros.until(lambda: len(said(started)) == 2 or not started.running(), 'a corner')
        moves = [line.split()[0] for line in said(started)]
        if moves != ['drove', 'turned'] and 'no frame for' in ready.node.output[before:]:
            return None
        assert moves == ['drove', 'turned'], started.output
        return started
    example = ready.ros.until(begun, 'a drive without a gap')
    assert (pose().pose.x, pose().pose.yaw) == pytest.approx((0.3, pi / 2), abs=0.05)
    ready.ros.until(lambda: pose().speed > 0.05, 'the second side')
    example.send(signal.SIGINT)
    assert example.ended() == 1
    assert fullmatch(
        r'drive_distance: stopped after 0\.\d\d m; canceled\n', example.printed[-1])
    ready.ros.until(lambda: ready.robot.standing, 'the wheels stand')


def test_a_tour_that_cannot_go_on_ends_with_a_sentence(ready):
    ready.renew()
    ready.robot.body.lift(True)
    ready.until_mode(Mode.PASSIVE)
    tour = ready.stage.example('tour.py')
    assert tour.ended() == 1
    assert said(tour) == ['set_leds: robot is in PASSIVE: call set_mode with SAFE first\n']


def test_a_goal_that_fails_says_why_and_the_next_one_is_done(ready):
    program = ready.stage.python('-c', FAILS)
    assert program.ended() == 0
    unknown, malformed, undocked, done = said(program)
    assert unknown.startswith("no action 'fly'; there are drive_distance, ")
    assert malformed == (
        'drive_distance: rejected as malformed; distance = 5000 m; allowed: -1000 to 1000\n')
    assert undocked == (
        'undock: not started; the robot is on no dock: there is nothing to leave\n')
    assert done == 'True\n'


def test_without_a_driver_the_program_ends_with_a_sentence(stage):
    program = stage.python('-c', ALONE)
    assert program.ended() == 0
    said, ended = program.printed
    assert said.startswith('goal_client: waits for the action drive_distance in ROS domain '
                           f'{stage.domain}; on this computer ')
    assert ended == ('GoalFailed: drive_distance: no driver offers /drive_distance in ROS domain '
                     f'{stage.domain}\n')
