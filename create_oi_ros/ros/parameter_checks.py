# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Declares the parameters to ROS, and refuses values that cannot work; says what is allowed."""

from collections.abc import Iterable
from dataclasses import fields, MISSING, replace
from difflib import get_close_matches
from typing import Any

from rcl_interfaces.msg import FloatingPointRange, ParameterDescriptor, SetParametersResult
from rclpy.node import Node
from rclpy.parameter import Parameter

from .parameters import Parameters
from .topics import CMD_VEL

DECLARED = Parameters.__dataclass_fields__
OF_ROS = ('use_sim_time', 'start_type_description_service')
"""Beginnings of the names of parameters that every ROS node has."""

TAKES = {float: 'a number', int: 'a whole number', bool: 'true or false', str: 'text'}


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
    """
    Declare all parameters; ValueError says which value is wrong and what is allowed.

    The node must declare what it is given by itself; that is declared anew, with descriptions.
    """
    given = {name: node.get_parameter(name).value for name in node.get_parameters_by_prefix('')}
    for unknown in sorted(given.keys() - DECLARED.keys()):
        if unknown.startswith('qos_overrides.'):
            raise ValueError(
                f'parameter {unknown} is not supported: leave it out. All topics are published '
                'as reliable; for best effort, let the subscriber ask for that'
                f'; {CMD_VEL} adapts to its publishers')
        if not unknown.startswith(OF_ROS):
            node.get_logger().warning(unknown_parameter(unknown))
            node.undeclare_parameter(unknown)
    values = {}
    for declaration in fields(Parameters):
        assert declaration.default is not MISSING
        name = declaration.name
        value = _whole_as_float(name, given.get(name, declaration.default))
        reason = (refusal(name, value) if type(value) is type(declaration.default)
                  else wrong_type(name, value))
        if reason is not None:
            raise ValueError(reason)
        if name in given:
            node.undeclare_parameter(name)
        values[name] = node.declare_parameter(
            name, value, descriptor(name), ignore_override=True).value
    parameters = Parameters(**values)
    reason = contradiction(parameters)
    if reason is not None:
        raise ValueError(reason)
    return parameters


def as_declared(parameters: list[Parameter]) -> list[Parameter]:
    """Accept whole numbers for floating-point parameters: people write 1 for 1.0."""
    return [Parameter(each.name, value=_whole_as_float(each.name, each.value))
            for each in parameters]


def _whole_as_float(name: str, value: Any) -> Any:
    return float(value) if type(value) is int and type(_default(name)) is float else value


def check(parameters: list[Parameter]) -> SetParametersResult:
    """Refuse new values that are not allowed; ROS has checked their types."""
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
    facts = DECLARED[name].metadata
    choices, low, high = facts['choices'], facts['low'], facts['high']
    if choices and value not in choices:
        return f'parameter {name} = {value!r}; allowed: {listed(choices)}'
    if isinstance(value, float) and value != value:
        return f'parameter {name} is not a number: give one'
    if low is not None and not low <= value <= high:
        return f'parameter {name} = {value:g}; allowed: {low:g} to {high:g}'
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
    """Say what a parameter takes, and how to write the value that was probably meant."""
    default = _default(name)
    takes = TAKES[type(default)]
    advice = f'write {written(default)}, for example'
    if isinstance(default, str) and isinstance(value, bool | int | float):
        choices = DECLARED[name].metadata['choices']
        advice = (f'allowed: {listed(choices)}' if choices else
                  f"""write '{value}' with its quotes (after -p: {name}:="'{value}'")""")
    elif isinstance(value, str) and _reads_as(type(default), value):
        advice = f'write {value} without quotes'
    elif isinstance(value, float) and value.is_integer() and isinstance(default, int):
        advice = f'write {written(type(default)(value))}'
    return f'parameter {name} = {written(value)} is of the wrong type: it takes {takes}; {advice}'


def written(value: Any) -> str:
    """Return a value as people write it in YAML."""
    return str(value).lower() if isinstance(value, bool) else repr(value)


def _reads_as(kind: type, text: str) -> bool:
    """Tell whether a text, without its quotes, is of a type."""
    if kind is bool:
        return text in ('true', 'false')
    try:
        kind(text)
    except ValueError:
        return False
    return True


def unknown_parameter(name: str) -> str:
    """Say that a parameter is not known, and which may be meant."""
    return f'parameter {name} is unknown and ignored{suggestion(name, DECLARED)}'


def suggestion(name: str, known: Iterable[str]) -> str:
    """Return a question for the nearest known name; empty where none is near."""
    found = get_close_matches(name, list(known), 1)
    return f': did you mean {found[0]}?' if found else ''


def listed(choices: tuple[Any, ...]) -> str:
    """Return allowed values as people read them."""
    return ', '.join(str(choice) for choice in choices)


def _default(name: str) -> Any:
    return DECLARED[name].default if name in DECLARED else None
