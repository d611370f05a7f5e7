"""The state of driver and robot as REP 107 diagnostics."""

from diagnostic_msgs.msg import DiagnosticStatus, KeyValue

from .driver import Driver, Link, LinkCounts

Values = dict[str, object]


def status(name: str, level: bytes, message: str, values: Values) -> DiagnosticStatus:
    """Make one status."""
    return DiagnosticStatus(
        level=level, name=name, message=message, hardware_id='iRobot Create',
        values=[KeyValue(key=key, value=str(value)) for key, value in values.items()])


def serial_link(
    name: str, driver: Driver, port: str, before: LinkCounts, seconds: float,
) -> DiagnosticStatus:
    """Say how well the line works; faults are counted over the last interval."""
    now = driver.counts
    faults = now.checksum_failures - before.checksum_failures
    faults += now.implausible_frames - before.implausible_frames
    garbage = now.garbage_bytes - before.garbage_bytes
    level, message = DiagnosticStatus.OK, 'frames arrive'
    if driver.link is not Link.UP:
        level, message = DiagnosticStatus.ERROR, driver.link.value
    elif faults or garbage:
        level, message = DiagnosticStatus.WARN, 'bytes arrive damaged'
    return status(f'{name}: serial link', level, message, {
        'port': port, 'frames per second': round((now.frames - before.frames) / seconds, 1),
        'damaged frames': faults, 'garbage bytes': garbage,
        'silences since start': now.silences,
        'checksum': driver.checksum.value if driver.checksum else 'not known yet',
        'bytes spare in a slot': driver.plan.budget.spare})


def mode(name: str, driver: Driver) -> DiagnosticStatus:
    """Say whether the robot is in the wanted mode, and why not."""
    known = driver.status
    actual = 'unknown' if known.actual is None else known.actual.name
    as_wanted = known.actual == known.wanted
    level = DiagnosticStatus.OK if as_wanted else DiagnosticStatus.WARN
    return status(f'{name}: mode', level, actual if as_wanted else known.reason or actual, {
        'mode': actual, 'wanted': known.wanted.name, 'reason': known.reason})
