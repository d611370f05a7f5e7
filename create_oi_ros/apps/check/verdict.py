# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""What was found of a robot, in plain words, with how sure it is and what that agrees with."""

from collections.abc import Sequence
import re
from typing import NamedTuple

from ... import oi
from ...driver import Health
from ...driver.tracking import in_words
from ...odometry import Knowledge, Response, Rounding, SignSource
from ...robot import MILLI, SLOT

LEAST_BANNER = 20
"""Characters in a row that are a banner, and not chance."""


class Finding(NamedTuple):
    """One thing that was found."""

    name: str
    answer: str
    agrees: str
    """What it agrees with."""


FRACTIONS = {
    Rounding.TRUNCATE: 'two reports of Create robots',
    Rounding.ROUND: 'no report of a Create; Create 2, maybe',
    Rounding.CARRY: 'one report of a Create, and what Create 2 seems to do'}
SIGNS = {SignSource.DRIVE: 'logs of Create 2 robots', SignSource.LAST_REQUEST: 'a guess',
         SignSource.REQUEST: 'a guess',
         SignSource.MOTION: 'what encoders with two channels would do'}
RESPONSES = {Response.LAG: 'one Create: about 15 mm from any speed',
             Response.RAMP: 'nothing measured',
             Response.SPRING: 'Create 2 robots, which overshoot by up to 40 %'}
CHECKSUMS = {oi.Checksum.MANUAL: ('without the header', 'the manual'),
             oi.Checksum.HARDWARE: ('with the header', 'reports of real robots')}


def of_wheels(known: Knowledge, checksum: oi.Checksum | None) -> list[Finding]:
    """Return what the odometry believes of the wheels and counts."""
    rounding, sign = known.likeliest
    wheels = known.wheels
    agrees = {
        'fractions of distance and angle': FRACTIONS[rounding],
        'sign of an encoder': SIGNS[sign], 'response': RESPONSES[wheels.response],
        'dead time': '30 to 60 ms, measured of Create 2 robots'
                     if 0.03 <= wheels.dead_time <= 0.06 else
                     'nothing published: Create 2 robots had 30 to 60 ms',
        'wheels over request': '1.000, measured of one Create',
        'slowest speed that moves it': '10 mm/s, reported of robots of the 400 series'
                                       if 0.008 <= wheels.dead_band <= 0.012 else
                                       'nothing published: 10 mm/s is reported of the 400 series',
        'wheel separation of the firmware': '0.258 m is reported; turns agree with 0.262 m on '
                                            'one Create',
        'frame period': _of_period(known.frame_period.value)}
    sums = ('not known', 'nothing') if checksum is None else CHECKSUMS[checksum]
    return [*(Finding(name, answer, agrees.get(name, 'nothing measured'))
              for name, answer in in_words(known).items()), Finding('checksum', *sums)]


def of_gyro(health: Health) -> Finding:
    """Return what was found of a gyro on the analog input."""
    gyro = None if health.robot is None else health.robot.gyro
    if gyro is None:
        why = 'nothing was seen' if health.gyro is None else health.gyro.problem
        return Finding('gyro', f'none that follows the robot: {why}', 'a robot without one')
    scale, unsure = gyro.scale
    return Finding('gyro', f'{scale:.2f} +- {unsure:.2f} degrees a second for each volt, zero at '
                   f'{gyro.zero.value:.3f} V', '80, the data sheet of an ADXRS613')


def _of_period(period: float) -> str:
    """Say what a length of a frame, s, agrees with."""
    if abs(period - SLOT) < 0.1 * MILLI:
        return 'the manual: 15 ms'
    if abs(period - 15.62 * MILLI) < 0.02 * MILLI:
        return 'Create 2: 15.616 to 15.625 ms'
    if period > 15.7 * MILLI:
        return 'nothing: was this computer too busy? The speeds depend on it'
    return 'neither the 15 ms of the manual nor the 15.62 ms of Create 2'


def banner_in(heard: bytes) -> Finding:
    """Say what the robot said when it was switched on."""
    texts = (' '.join(run.decode().split()) for run in re.findall(rb'[\t\n\r -~]+', heard))
    longest = max(texts, key=len, default='')
    if len(longest) < LEAST_BANNER:
        return Finding('banner', 'nothing that can be read', 'the manual, which has none')
    return Finding('banner', f'{len(longest)} characters: {longest!r}',
                   'reports of some 140 bytes of text')


def lines(findings: Sequence[Finding]) -> list[str]:
    """Return the verdict as lines of text."""
    width = max(len(finding.name) for finding in findings)
    return [line for name, answer, agrees in findings for line in (
        f'{name:{width}}  {answer}', f'{"":{width}}  agrees with: {agrees}')]


def as_mapping(findings: Sequence[Finding]) -> dict[str, dict[str, str]]:
    """Return the verdict for YAML."""
    return {name: {'answer': answer, 'agrees with': agrees} for name, answer, agrees in findings}
