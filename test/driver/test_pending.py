# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Outcomes of requests: once, and to everybody who waits."""

from create_oi_ros.driver.outbox import done, Outcome, Pending, refused


def test_whoever_waits_is_called_back_once():
    pending, seen = Pending(), []
    pending.then(seen.append)
    assert pending.outcome is None
    pending.end(True, 'stored', b'\x80')
    pending.end(False, 'too late')
    assert seen == [Outcome(True, 'stored', b'\x80')]
    assert pending.outcome == seen[0]


def test_whoever_comes_late_is_called_back_at_once():
    seen: list[Outcome] = []
    done('wheels stopped').then(seen.append)
    refused('no robot answers').then(seen.append)
    assert seen == [Outcome(True, 'wheels stopped'), Outcome(False, 'no robot answers')]
