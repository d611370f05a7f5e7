# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""The SROS 2 policy allows what the nodes use and nothing else; keys keep others out."""

from contextlib import closing
from importlib.util import find_spec
import os
import re
import subprocess
import time
from xml.etree import ElementTree

from create_oi_msgs.msg import Mode
from create_oi_msgs.srv import SetMode
from nav_msgs.msg import Odometry
import pytest
import rclpy
from rclpy.parameter import Parameter
from rclpy.task import Future

from create_oi_ros.apps.lidar import LidarNode
from create_oi_ros.apps.web.viewers import WebNode
from create_oi_ros.ros.actions import ACTION_TYPES, ACTIONS
from create_oi_ros.ros.bags import Recorder
from create_oi_ros.ros.node import CreateNode
from create_oi_ros.ros.services import SERVICES
from create_oi_ros.ros.topics import ALL_TOPICS, LATCHED
from support.ros import Listener, own_domain, scene, TIMEOUT
from support.source import ROOT

POLICY = ElementTree.parse(ROOT / 'config' / 'sros2_policy.xml').getroot()
DOCS = (ROOT / 'docs' / 'security.md').read_text('utf-8')
EVERY_NODE = {'/parameter_events', '/rosout'}


def profile_of(enclave: str, node: str = '') -> ElementTree.Element:
    """Return the rules of an enclave for a node; without a name for its first."""
    which = f"[@node='{node}']" if node else '[1]'
    profile, = POLICY.findall(f".//enclave[@path='{enclave}']/profiles/profile{which}")
    return profile


def allowed(enclave: str, what: str, node: str = '') -> set[str]:
    """Return the full names that an enclave may publish, subscribe, reply or request."""
    profile = profile_of(enclave, node)
    names = set()
    for rule in profile.findall(f"./*[@{what}='ALLOW']"):
        assert set(rule.attrib) == {what}
        for name in rule:
            assert name.tag != 'action'
            whole = re.sub('^~', f"/{profile.get('node')}", str(name.text))
            names.add(whole if whole.startswith('/') else f"{profile.get('ns')}{whole}")
    return names


OF_ACTIONS = {
    'publish': ('execute', ('feedback', 'status')), 'subscribe': ('call', ('feedback', 'status')),
    'reply': ('execute', ('send_goal', 'cancel_goal', 'get_result')),
    'request': ('call', ('send_goal', 'cancel_goal', 'get_result'))}
"""What `execute` and `call` of an action allow, as `ros2 security` writes it."""


def actions(enclave: str, what: str, node: str = '') -> set[str]:
    """Return the names of the actions that an enclave may execute or call."""
    profile = profile_of(enclave, node)
    return {str(name.text) for name in profile.findall(f"./actions[@{what}='ALLOW']/action")}


def allowed_by_actions(enclave: str, what: str, node: str = '') -> set[str]:
    """Return the full names that an enclave may use as parts of its actions."""
    rule, parts = OF_ACTIONS[what]
    return {f'/{name}/_action/{part}' for name in actions(enclave, rule, node) for part in parts}


def full(names: list[str]) -> set[str]:
    """Return names without their namespace."""
    return {name if name.startswith('/') else f'/{name}' for name in names}


@pytest.fixture(scope='module')
def node(tmp_path_factory):
    """Return the node, in a domain of its own, with a page that knows it, and what they start."""
    with own_domain() as domain:
        rclpy.init(args=[], domain_id=domain)
        made = CreateNode(Future(), parameter_overrides=[Parameter('gyro', value='analog')])
        web = WebNode()
        lidar, record = LidarNode(), rclpy.create_node('create_record')
        recorder = Recorder(record, tmp_path_factory.mktemp('bags') / 'bag')
        for name in ACTION_TYPES:
            web.driver.client(name)  # as a page that has sent every goal
        deadline = time.monotonic() + TIMEOUT
        while not web.velocity.driver_listens:
            assert time.monotonic() < deadline
            web.velocity.find_driver(time.monotonic())
        web.velocity.publish(0.0, 0.0)
        yield made
        recorder.close()
        for each in web, lidar, record:
            each.destroy_node()
        made.stop()
        made.destroy_node()
        rclpy.shutdown()


@pytest.mark.parametrize(('what', 'ask'), [
    ('publish', 'get_publisher_names_and_types_by_node'),
    ('subscribe', 'get_subscriber_names_and_types_by_node'),
    ('reply', 'get_service_names_and_types_by_node'),
    ('request', 'get_client_names_and_types_by_node'),
])
@pytest.mark.parametrize(('enclave', 'name'), [
    ('/create', 'create'), ('/create', 'create_cmd_vel'), ('/create', 'create_lidar'),
    ('/web', 'create_web'), ('/web', 'create_record')])
def test_a_node_may_do_what_it_does_and_no_more(node, enclave, name, what, ask):
    used = {each for each, _ in getattr(node, ask)(name, '/')}
    assert allowed(enclave, what, name) | allowed_by_actions(enclave, what, name) == used


def test_a_pilot_may_drive_listen_and_ask():
    pilot = '/pilot'
    assert allowed(pilot, 'publish') == {'/cmd_vel', *EVERY_NODE}
    assert allowed(pilot, 'subscribe') == full([topic.name for topic in ALL_TOPICS])
    assert allowed(pilot, 'request') == full([service.name for service in SERVICES])
    assert actions(pilot, 'call') == {action.name for action in ACTIONS}


@pytest.mark.skipif(find_spec('sros2') is None, reason='no `ros2 security` here')
def test_with_the_keys_of_the_page_nobody_else_hears_or_drives(tmp_path, monkeypatch):
    making, = (block for block in re.findall('```\n(.*?)```', DOCS, re.S) if 'keystore' in block)
    securing, = re.findall('^export (.* ROS_SECURITY_STRATEGY=Enforce)$', DOCS, re.M)
    with scene(tmp_path) as stage:
        stranger, robot = stage.ros, stage.robot()
        monkeypatch.setenv('HOME', str(tmp_path))
        monkeypatch.setenv('ROS_DOMAIN_ID', str(stage.domain))
        subprocess.run(
            ['bash', '-ec', f'{making}ros2 security create_enclave create_keys /admin'],
            check=True, timeout=120)
        for each in securing.split():
            name, _, value = each.partition('=')
            monkeypatch.setenv(name, os.path.expanduser(value))
        stage.program(
            'create_node', '--ros-args', '-p', f'port:={robot.link}', '--enclave', '/create')
        monkeypatch.setenv('ROS_SECURITY_ENCLAVE_OVERRIDE', '/admin')
        with closing(Listener(stage.domain)) as admin:
            heard, overheard = (each.listen(Odometry, 'odom') for each in (admin, stranger))
            modes = admin.listen(Mode, 'mode', LATCHED)
            admin.until(lambda: modes and modes[-1].mode == Mode.SAFE)
            assert admin.call(SetMode, 'set_mode', mode=Mode.SAFE).success
            enough = time.monotonic() + 3.0
            stranger.drive(0.2, 0.0, lambda: time.monotonic() > enough)
            heard.clear()
            admin.until(lambda: len(heard) > 20)
            assert not overheard
            assert heard[-1].pose.pose.position.x == 0.0
            admin.drive(0.2, 0.0, lambda: heard[-1].pose.pose.position.x > 0.05)
