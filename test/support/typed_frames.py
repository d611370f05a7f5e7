# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""A driver that is polled, and hears frames, at moments that a test chooses; without a robot."""

from create_oi_ros import oi
from create_oi_ros.driver import Driver, Severity
from create_oi_ros.driver.outbox import WAKE_UP

BEGIN = 100.0


def notices(driver: Driver) -> list[tuple[Severity, str]]:
    """Return what was said since the last time."""
    return [(event.severity, event.text) for event in iter(driver.next_event, None)
            if hasattr(event, 'severity')]


def polled(driver: Driver, *times: float) -> bytes:
    """Let time pass; return what is sent at the last of these times."""
    for now in times:
        driver.poll(now)
        sent = driver.data_to_send()
    return sent


def heard(driver: Driver, now: float, packets: oi.PacketList | None = None,
          mode: oi.Mode = oi.Mode.SAFE) -> None:
    """Let a frame come, of a robot that stands; by default in Safe, as it was asked for."""
    packets = packets or driver.plan.asked or driver.plan.full
    values = [int(name == 'oi_mode') * int(mode) for name in packets.names]
    driver.receive(packets.pack_frame(values), now)


def called() -> Driver:
    """Return a driver that has just opened its port and called."""
    driver = Driver()
    driver.connected(BEGIN)
    assert polled(driver, BEGIN).startswith(WAKE_UP + oi.Start().encode())
    return driver


def answered() -> Driver:
    """Return a driver whose robot has answered a moment ago."""
    driver = called()
    for slot in range(1, 20):
        heard(driver, BEGIN + slot * 0.015)
        polled(driver, BEGIN + slot * 0.015)
    assert driver.state.answered
    notices(driver)
    return driver


LAST = BEGIN + 19 * 0.015
