# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""What was found of a robot, in plain words, with how sure it is and what that agrees with."""

from collections.abc import Sequence
from math import exp
from typing import NamedTuple

from ... import oi
from ...driver import Health
from ...odometry import Family, Knowledge, Known, Rounding, SignSource
from ...robot import FIRMWARE_SEPARATION, MILLI, SLOT
from .conclusion import Conclusion, FAST_MOVE, time_constant
from .trial_wheels import Kind

SLOW_MOVE = 0.076
"""m/s, a speed at which a Create was measured."""
LEAST_BANNER = 20
"""Characters in a row that are a banner, and not chance."""


class Finding(NamedTuple):
    """One thing that was found."""

    name: str
    answer: str
    certainty: float | None
    """Probability; None: it was seen, or it has deviations of its own."""
    agrees: str
    """What it agrees with."""


FRACTIONS = {
    Rounding.TRUNCATE: ('cut off and lost at each reading', 'two reports of Create robots'),
    Rounding.ROUND: ('rounded, and the rest is lost', 'no report of a Create; Create 2, maybe'),
    Rounding.CARRY: ('kept for the next reading',
                     'one report of a Create, and what Create 2 seems to do')}
SIGNS = {
    SignSource.DRIVE: ('of the drive: the last request that was not zero, after its dead time',
                       'logs of Create 2 robots'),
    SignSource.LAST_REQUEST: ('of the last request that was not zero, at once', 'a guess'),
    SignSource.LATE_REQUEST: ('of the request after its dead time; a wheel told to stop counts '
                              'forwards', 'a part of the logs of Create 2 robots'),
    SignSource.REQUEST: ('of the request; a wheel told to stop counts forwards', 'a guess'),
    SignSource.MOTION: ('of the motion itself', 'what encoders with two channels would do')}
CHECKSUMS = {oi.Checksum.MANUAL: ('without the header', 'the manual'),
             oi.Checksum.HARDWARE: ('with the header', 'reports of real robots')}


def of_wheels(found: Conclusion, health: Health) -> list[Finding]:
    """Return what the moves have shown."""
    known = found.knowledge
    rounding, sign = known.likeliest
    fractions, source = FRACTIONS[rounding], SIGNS[sign]
    checksum = CHECKSUMS.get(health.checksum) if health.checksum is not None else None
    period, width = known.frame_period, FIRMWARE_SEPARATION * known.separation_factor.value
    return [
        Finding('fractions of distance and angle', fractions[0], known.rounding[rounding],
                fractions[1]),
        Finding('sign of an encoder', source[0], known.encoder_sign[sign], source[1]),
        _response(found),
        Finding('dead time', _milliseconds(known.dead_time), None,
                '30 to 60 ms, measured of Create 2 robots'
                if 0.03 <= known.dead_time.value <= 0.06 else
                'nothing published: Create 2 robots had 30 to 60 ms'),
        Finding('wheels over request', f'right {_ratio(known.right_gain)}, left '
                f'{_ratio(known.left_gain)}, at high speeds', None,
                '1.000, measured of one Create'),
        Finding('braking', f'{known.braking.value:.2f} +- {known.braking.deviation:.2f} times as '
                'fast as speeding up', None, 'nothing published'),
        _dead_band(known),
        Finding('wheel separation of the firmware', f'{width / MILLI:.1f} mm', None,
                '0.258 m is reported; turns agree with 0.262 m on one Create'),
        Finding('frame period', f'{period.value / MILLI:.3f} ms', None,
                'the manual: 15 ms' if abs(period.value - SLOT) < 1e-4 else
                'Create 2: 15.616 to 15.625 ms' if abs(period.value - 0.01562) < 2e-5 else
                'nothing: was this computer too busy? The speeds depend on it' if period.value >
                0.0157 else 'neither the 15 ms of the manual nor the 15.62 ms of Create 2'),
        Finding('checksum', 'not known' if checksum is None else checksum[0], None,
                'nothing' if checksum is None else checksum[1])]


def _milliseconds(known: Known) -> str:
    return f'{known.value / MILLI:.0f} +- {known.deviation / MILLI:.0f} ms'


def _ratio(known: Known) -> str:
    return f'{known.value:.3f} +- {known.deviation:.3f}'


def _response(found: Conclusion) -> Finding:
    """Say how a wheel follows a step of its request."""
    kind, sure = found.wheels.kind, found.family_probability
    times = ' and '.join(f'{time_constant(kind, speed) / MILLI:.0f} ms at {speed} m/s'
                         for speed in (SLOW_MOVE, FAST_MOVE))
    if found.wheels.start.family is Family.SPRING:
        overshoot = 100 * exp(kind[Kind.BOUND])
        return Finding('response', f'second order: overshoots by {overshoot:.0f} %, 1 / natural '
                       f'frequency is {times}', sure, 'Create 2 robots overshoot by up to 40 %')
    if found.is_ramp:
        return Finding('response', f'a constant acceleration of {1 / kind[Kind.BOUND]:.2f} m/s2',
                       sure, 'nothing measured; it was assumed before')
    return Finding('response', f'first order, time constant {times}', sure,
                   'one Create: about 200 ms')


def _dead_band(known: Knowledge) -> Finding:
    stands, moves = (round(each / MILLI) for each in known.dead_band)
    return Finding('slowest speed that moves it', f'{moves} mm/s ({stands} mm/s does not)', None,
                   '10 mm/s, reported of robots of the 400 series' if 8 <= moves <= 12 else
                   'nothing published: 10 mm/s is reported of the 400 series')


def banner_in(heard: bytes) -> Finding:
    """Say what the robot said when it was switched on."""
    longest = max(oi_text(heard), key=len, default='')
    if len(longest) < LEAST_BANNER:
        return Finding('banner', 'nothing that can be read', None, 'the manual, which has none')
    return Finding('banner', f'{len(longest)} characters: {longest!r}', None,
                   'reports of some 140 bytes of text')


def oi_text(heard: bytes) -> list[str]:
    """Return the runs of letters in bytes."""
    text = ''.join(chr(byte) if 32 <= byte < 127 or byte in (9, 10, 13) else '\0'
                   for byte in heard)
    return [' '.join(run.split()) for run in text.split('\0') if run.strip()]


def lines(findings: Sequence[Finding]) -> list[str]:
    """Return the verdict as lines of text."""
    width = max(len(finding.name) for finding in findings)
    said = []
    for finding in findings:
        sure = '' if finding.certainty is None else f' ({_percent(finding.certainty)} sure)'
        said.append(f'{finding.name:{width}}  {finding.answer}{sure}')
        said.append(f'{"":{width}}  agrees with: {finding.agrees}')
    return said


def _percent(certainty: float) -> str:
    return 'over 99.9 %' if certainty > 0.999 else f'{certainty:.1%}'


def as_mapping(findings: Sequence[Finding]) -> dict[str, dict[str, str | float]]:
    """Return the verdict for YAML."""
    return {finding.name: {
        'answer': finding.answer, 'agrees with': finding.agrees,
        **({} if finding.certainty is None else {'certainty': round(finding.certainty, 4)})}
        for finding in findings}
