# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Files beside the code: model, parameter file, RViz and udev settings."""

import subprocess
import sys
from xml.etree import ElementTree

import pytest
import yaml

from create_oi_ros.odometry import Geometry
from create_oi_ros.ros.messages import WHEEL_JOINTS
from create_oi_ros.ros.parameters import Parameters
from document import config
from support.source import ROOT

URDF = ROOT / 'urdf' / 'create.urdf'
MODEL = ElementTree.parse(URDF).getroot()
LINKS = {link.get('name') for link in MODEL.iter('link')}
JOINTS = {joint.get('name'): joint for joint in MODEL.iter('joint')}


def ends(joint: ElementTree.Element) -> tuple[str, str]:
    """Return the parent and the child of a joint."""
    return joint.find('parent').get('link'), joint.find('child').get('link')


def canonical(text: str) -> str:
    return ElementTree.canonicalize(text, strip_text=True)


def numbers(element: ElementTree.Element, name: str) -> list[float]:
    """Return the numbers of an attribute."""
    return [float(number) for number in element.get(name, '').split()]


def test_the_model_is_a_tree_that_begins_on_the_floor():
    children = [ends(joint)[1] for joint in JOINTS.values()]
    assert len(children) == len(set(children))
    assert LINKS - set(children) == {Parameters.base_frame}
    assert {parent for joint in JOINTS.values() for parent in ends(joint)} <= LINKS


def test_the_wheels_are_those_of_the_joint_states_and_of_the_odometry():
    left, right = (JOINTS[name] for name in WHEEL_JOINTS)
    for joint in (left, right):
        assert joint.get('type') == 'continuous'
        assert numbers(joint.find('axis'), 'xyz') == [0, 1, 0]
    apart = numbers(left.find('origin'), 'xyz')[1] - numbers(right.find('origin'), 'xyz')[1]
    assert apart == pytest.approx(Geometry().wheel_separation)
    for wheel in ('left_wheel_link', 'right_wheel_link'):
        link = next(link for link in MODEL.iter('link') if link.get('name') == wheel)
        radii = {float(cylinder.get('radius')) for cylinder in link.iter('cylinder')}
        assert radii == {Geometry().wheel_radius}


def of_xacro(*arguments: str) -> str:
    """Return the model that xacro makes."""
    return subprocess.run(
        [sys.executable, '-c', 'import xacro; xacro.main()', f'{URDF}.xacro', *arguments],
        text=True, capture_output=True, check=True).stdout


def test_the_model_is_made_from_the_xacro():
    assert canonical(of_xacro()) == canonical(URDF.read_text()), 'run `make docs`'


def test_the_xacro_takes_a_prefix_and_a_parent():
    model = ElementTree.fromstring(of_xacro('prefix:=left_', 'parent:=stage'))
    assert {link.get('name') for link in model.iter('link')} == {f'left_{link}' for link in LINKS}
    joints = {joint.get('name'): ends(joint) for joint in model.iter('joint')}
    assert joints['left_parent_joint'] == ('stage', 'left_base_footprint')
    assert set(joints) == {'left_parent_joint', *(f'left_{joint}' for joint in JOINTS)}


def test_the_parameter_file_is_made_from_the_code():
    text = (ROOT / 'config' / 'create.yaml').read_text()
    assert text == config(), 'run `make docs`'
    values = yaml.safe_load(text)['/**']['ros__parameters']
    defaults = {name: list(field.default) if isinstance(field.default, tuple) else field.default
                for name, field in Parameters.__dataclass_fields__.items()}
    assert values == defaults
    assert {name: type(value) for name, value in values.items()} == {
        name: type(value) for name, value in defaults.items()}
