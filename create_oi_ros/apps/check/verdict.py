# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""What was found of a robot, in plain words, with how sure it is and what that agrees with."""

from collections.abc import Sequence
import re
from typing import NamedTuple

from ... import oi
from ...driver import Health
from ...odometry import Knowledge, Known, Rounding, SignSource
from ...robot import FIRMWARE_SEPARATION, MILLI, SLOT

LEAST_BANNER = 20
"""Characters in a row that are a banner, and not chance."""


class Finding(NamedTuple):
    """One thing that was found."""

    name: str
    answer: str
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
    SignSource.REQUEST: ('of the request; a wheel told to stop counts forwards', 'a guess'),
    SignSource.MOTION: ('of the motion itself', 'what encoders with two channels would do')}
QUICK = 0.2
"""m/s at which it is said how late the wheels are."""
CHECKSUMS = {oi.Checksum.MANUAL: ('without the header', 'the manual'),
             oi.Checksum.HARDWARE: ('with the header', 'reports of real robots')}


def of_wheels(known: Knowledge, checksum: oi.Checksum | None) -> list[Finding]:
    """Return what the odometry believes of the wheels and counts."""
    rounding, sign = known.likeliest
    width, late, dead = (FIRMWARE_SEPARATION / known.angle_factor.value / MILLI,
                         known.delay(QUICK), known.dead_time.value)
    sums = ('not known', 'nothing') if checksum is None else CHECKSUMS[checksum]
    fractions, of_fractions = FRACTIONS[rounding]
    signs, of_signs = SIGNS[sign]
    return [Finding(*row) for row in (
        ('fractions of distance and angle', fractions + _sure(known.rounding[rounding]),
         of_fractions),
        ('sign of an encoder', signs + _sure(known.encoder_sign[sign]), of_signs),
        ('late', f'{late.value / MILLI:.0f} +- {late.deviation / MILLI:.0f} ms at {QUICK} m/s, '
                 f'{1e3 * QUICK * (late.value - dead):.0f} mm of coasting',
         'one Create: it coasts about 15 mm from any speed'),
        ('dead time', f'about {dead / MILLI:.0f} ms', 'Create 2 robots: 30 to 60 ms'),
        ('braking', f'{known.braking.value:.1f} times as fast as it speeds up',
         'nothing measured'),
        ('wheels over request', f'right {_ratio(known.right_gain)}, left '
                                f'{_ratio(known.left_gain)}', '1.000, measured of one Create'),
        ('wheel separation of the firmware', f'{width:.1f} mm',
         '0.258 m is reported; turns agree with 0.262 m on one Create'),
        ('frame period', f'{known.frame_period.value / MILLI:.3f} ms',
         _of_period(known.frame_period.value)),
        ('checksum', *sums))]


def _ratio(known: Known) -> str:
    return f'{known.value:.3f} +- {known.deviation:.3f}'


def _sure(probability: float) -> str:
    return f' ({"over 99.9 %" if probability > 0.999 else f"{probability:.1%}"} sure)'


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
