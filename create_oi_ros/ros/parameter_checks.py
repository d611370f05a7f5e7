# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Declares the parameters to ROS, and refuses values that cannot work; says what is allowed."""

from collections.abc import Iterable
from dataclasses import fields, MISSING, replace
from typing import Any

from rcl_interfaces.msg import FloatingPointRange, ParameterDescriptor, SetParametersResult
from rclpy.exceptions import (
    InvalidParameterTypeException,
    InvalidParameterValueException,
    ParameterException,
)
from rclpy.node import Node
from rclpy.parameter import Parameter

from .parameters import Parameters

DECLARED = Parameters.__dataclass_fields__
OF_ROS = ('use_sim_time', 'start_type_description_service', 'qos_overrides.')
"""Beginnings of the names of parameters that every ROS node has."""


def descriptor(name: str) -> ParameterDescriptor:
    """Describe a parameter to ROS."""
    facts = DECLARED[name].metadata
    described = ParameterDescriptor(description=facts['description'], read_only=facts['fixed'])
    if facts['low'] is not None:
        described.floating_point_range = [
            FloatingPointRange(from_value=facts['low'], to_value=facts['high'])]
    if facts['choices']:
        described.additional_constraints = f'one of {listed(facts["choices"])}'
    return described


def declare(node: Node) -> Parameters:
    """Declare all parameters; ValueError says which value is wrong and what is allowed."""
    given = dict(getattr(node, '_parameter_overrides', {}))
    for unknown in sorted(given.keys() - DECLARED.keys()):
        if not unknown.startswith(OF_ROS):
            node.get_logger().warning(unknown_parameter(unknown))
    values = {}
    for declaration in fields(Parameters):
        assert declaration.default is not MISSING
        name = declaration.name
        try:
            values[name] = node.declare_parameter(
                name, declaration.default, descriptor(name)).value
        except InvalidParameterTypeException:
            raise ValueError(wrong_type(name, given[name].value)) from None
        except (InvalidParameterValueException, ParameterException) as error:
            raise ValueError(f'parameter {name}: {error}') from error
        reason = refusal(name, values[name])
        if reason is not None:
            raise ValueError(reason)
    parameters = Parameters(**values)
    reason = contradiction(parameters)
    if reason is not None:
        raise ValueError(reason)
    return parameters


def as_declared(parameters: list[Parameter]) -> list[Parameter]:
    """Accept whole numbers for floating-point parameters: people write 1 for 1.0."""
    return [Parameter(each.name, value=float(each.value))
            if type(each.value) is int and type(_default(each.name)) is float else each
            for each in parameters]


def check(parameters: list[Parameter]) -> SetParametersResult:
    """Refuse new values that are not allowed; ROS itself checks the ranges."""
    reasons = [
        reason for parameter in parameters
        if parameter.name in DECLARED
        and (reason := refusal(parameter.name, parameter.value)) is not None]
    return SetParametersResult(successful=not reasons, reason='; '.join(reasons))


def changed(parameters: Parameters, new: list[Parameter]) -> Parameters:
    """Take over values that were set while the node runs."""
    return replace(parameters, **{p.name: p.value for p in new if p.name in DECLARED})


def refusal(name: str, value: Any) -> str | None:
    """Say why a value is not allowed; None where it is."""
    choices = DECLARED[name].metadata['choices']
    if choices and value not in choices:
        return f'parameter {name} = {value!r}; allowed: {listed(choices)}'
    if isinstance(value, float) and value != value:
        return f'parameter {name} is not a number: give one'
    if value == '' and _default(name) != '':
        return f'parameter {name} is empty: give a value, or leave it out'
    if name.endswith('_frame') and value.startswith('/'):
        return (f"parameter {name} = {value!r}; tf2 takes no leading '/': "
                f"write {value.lstrip('/')!r}")
    return None


def contradiction(parameters: Parameters) -> str | None:
    """Say which values contradict each other; None where none do."""
    if parameters.odom_frame == parameters.base_frame:
        return (f'parameters odom_frame and base_frame are both {parameters.odom_frame!r}: a '
                'frame cannot move in itself; give them different names')
    if parameters.battery_low < parameters.battery_empty:
        return (f'parameter battery_low = {parameters.battery_low} is below battery_empty = '
                f'{parameters.battery_empty}: a battery is low before it is empty')
    return None


def wrong_type(name: str, value: Any) -> str:
    """Say what type a parameter has, and how to write the value."""
    default = _default(name)
    said = f'parameter {name} = {value!r} is of the wrong type'
    if type(default) is float and type(value) is int:
        return f'{said}: write {float(value)}'
    example = str(default).lower() if isinstance(default, bool) else repr(default)
    return f'{said}: it takes a {type(default).__name__}, such as {example}'


def unknown_parameter(name: str) -> str:
    """Say that a parameter is not known, and which may be meant."""
    return f'parameter {name} is unknown and ignored{suggestion(name, DECLARED)}'


def suggestion(name: str, known: Iterable[str]) -> str:
    """Return a question for the nearest known name; empty where none is near."""
    from difflib import get_close_matches  # here: few programs ever need it
    found = get_close_matches(name, list(known), 1)
    return f': did you mean {found[0]}?' if found else ''


def listed(choices: tuple[Any, ...]) -> str:
    """Return allowed values as people read them."""
    return ', '.join(str(choice) for choice in choices)


def _default(name: str) -> Any:
    return DECLARED[name].default if name in DECLARED else None
