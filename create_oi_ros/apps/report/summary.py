# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Describes a recording in words: its events, its warnings, a summary."""

from __future__ import annotations

from datetime import datetime, UTC
from math import hypot, isfinite
from typing import NamedTuple

from ...ros.collector import Span
from .recording import Recording, TOPICS

LEVELS = {'warn': 'warning', 'error': 'error'}
HOUR = 3600


class TimelineEvent(NamedTuple):
    """Something that happened, with its time."""

    time: float
    kind: str
    text: str


def clock(seconds: float) -> str:
    """Return seconds as text, such as 1:02:03 or 2:03.4."""
    # Rounded first: 59.99 s is 1:00.0.
    minutes, rest = divmod(round(seconds, 0 if seconds >= HOUR else 1), 60)
    hours, minutes = divmod(int(minutes), 60)
    return f'{hours}:{minutes:02d}:{rest:02.0f}' if hours else f'{minutes}:{rest:04.1f}'


def events(recording: Recording) -> list[TimelineEvent]:
    """Return all events, in order of time."""
    found, before = [], ''
    for kind, spans in recording.events.spans.items():
        for span in spans.all:
            if kind != 'mode':
                found.append(TimelineEvent(span.start, kind, f'{span.sentence}{_duration(span)}'))
            elif span.text != before:
                before = span.text
                found.append(TimelineEvent(span.start, kind, span.sentence))
    for span in recording.events.jumps.all:
        found.append(TimelineEvent(span.start, 'odometry', span.sentence))
    for span in recording.gaps:
        found.append(TimelineEvent(span.start, 'gap', f'Gap{_duration(span)}: {span.text}'))
    return sorted(found, key=lambda each: each.time)


def _duration(span: Span) -> str:
    return f', {span.end - span.start:.1f} s'


def travelled(recording: Recording) -> float:
    """Return the length of the track, metres, without jumps of the odometry."""
    xs, ys, jumps = recording.odom['x'], recording.odom['y'], {
        span.start for span in recording.events.jumps.all}
    steps = zip(xs, xs[1:], ys, ys[1:], recording.odom.times[1:])
    return sum(hypot(b - a, d - c) for a, b, c, d, time in steps if time not in jumps)


def summary(recording: Recording) -> list[str]:
    """Return the sentences at the top of the report."""
    day = datetime.fromtimestamp(recording.began, UTC).strftime('%Y-%m-%d %H:%M:%S UTC')
    robot = f' of {recording.robot}' if recording.robot else ''
    lines = [f'Recorded{robot} on {day}; {clock(recording.seconds)} (minutes:seconds), '
             f'{recording.messages} messages.']
    if recording.odom:
        fastest = max((abs(speed) for speed in recording.odom['speed'] if isfinite(speed)),
                      default=0.0)
        lines.append(f'It drove {travelled(recording):.2f} m, at most {fastest:.2f} m/s.')
    lines += [_times_in_modes(recording), _counts(recording), _battery(recording)]
    lines += [_link(recording), _gaps(recording)]
    version = recording.events.settings.get('version')
    if version:
        port = recording.events.settings.get('port', 'unknown')
        lines.append(f'Driver version {version}, port {port}.')
    lines.append(recording.damage)
    return [line for line in lines if line]


def absent(recording: Recording) -> list[str]:
    """Return what the bag lacks: topics, and values that are never known."""
    missing = [name for name in TOPICS if name not in recording.heard]
    unknown = [f'{name} of the battery (never known)' for name in ('volts', 'amperes', 'charge')
               if recording.battery and not any(map(isfinite, recording.battery[name]))]
    return missing + unknown


def _times_in_modes(recording: Recording) -> str:
    times: dict[str, float] = {}
    for span in recording.events.spans['mode'].all:
        times[span.text] = times.get(span.text, 0.0) + span.end - span.start
    parts = [f'{text} {seconds:.1f} s' for text, seconds in times.items()]
    return f'Modes: {", ".join(parts)}.' if parts else ''


def _counts(recording: Recording) -> str:
    names = {'bumper': 'bumps', 'cliff': 'cliffs', 'wheel drop': 'wheel drops',
             'buttons': 'pressed buttons', 'song': 'songs'}
    parts = [f'{name}: {len(recording.events.spans[kind])}' for kind, name in names.items()
             if kind.replace(' ', '_') in recording.heard]
    return f'Number of {", ".join(parts)}.' if parts else ''


def _battery(recording: Recording) -> str:
    volts, charge = ([each for each in recording.battery[name] if isfinite(each)]
                     for name in ('volts', 'charge'))
    if not volts:
        return ''
    known = f', {charge[0]:.0f} % to {charge[-1]:.0f} %' if charge else ''
    return f'Battery {volts[0]:.1f} V to {volts[-1]:.1f} V{known}.'


def _link(recording: Recording) -> str:
    if not recording.link:
        return ''
    damaged = sum(each for each in recording.link['damaged'] if isfinite(each))
    garbage = sum(each for each in recording.link['garbage'] if isfinite(each))
    rates = sorted(each for each in recording.link['frames'] if isfinite(each))
    middle = f'{rates[len(rates) // 2]:.0f} frames/s' if rates else 'frames not counted'
    return f'Serial link: {middle}, {damaged:.0f} damaged frames, {garbage:.0f} garbage bytes.'


def _gaps(recording: Recording) -> str:
    if not recording.gaps:
        return f'{"What could be read" if recording.faults else "The recording"} has no gap.'
    longest = max(recording.gaps, key=lambda span: span.end - span.start)
    return (f'Gaps in the recording: {len(recording.gaps)}, the longest at '
            f'{clock(longest.start)}{_duration(longest)}.')


def warnings(recording: Recording) -> list[TimelineEvent]:
    """Return the warnings of the diagnostics, in order of time."""
    return sorted(
        (TimelineEvent(span.start, subject, f'{LEVELS[span.level]}: {span.text}{_duration(span)}')
         for subject, spans in recording.events.warnings.items() for span in spans.all),
        key=lambda each: each.time)
