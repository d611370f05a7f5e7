# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""The fault campaign in its short form: a few faults, once each; `make faults` does them all."""

from random import Random

import pytest

from campaign.cases import FAULTS
from campaign.fault import Result
from campaign.faults import attempt
from campaign.noise import LEAST_KEPT, noise
from campaign.stage import staged
from campaign.table import as_json, markdown, Row
from create_oi_ros import oi

BY_NAME = {fault.name: fault for fault in FAULTS}
KEEPING = ('cable out and in', 'robot off and on', 'robot deaf for a while',
           'bad line: 5 % flipped, short, garbage', 'all bytes garbled', 'commands end', 'stop',
           'robot told to wait for ever', 'SIGSTOP, SIGCONT')
ENDING = ('command cut short before connecting', 'SIGKILL', 'SIGTERM',
          'exception on the serial thread')
SLACK = 5.0
"""Factor for the limits: this machine may be busy."""


@pytest.fixture(scope='module')
def kept_stage(tmp_path_factory):
    """Return a stage whose node lives on from fault to fault."""
    with staged(tmp_path_factory.mktemp('stage')) as made:
        yield made


@pytest.fixture(scope='module')
def ending_stage(tmp_path_factory):
    """Return a stage whose node ends with each fault."""
    with staged(tmp_path_factory.mktemp('stage')) as made:
        yield made


def assert_survived(name, stage):
    """Make a fault once; fail if the try has failed."""
    row = Row(BY_NAME[name], slack=SLACK)
    result = attempt(row.fault, stage, Random(name))
    node = stage.node.output if stage.node is not None else ''
    assert not row.failure(result), node


@pytest.mark.parametrize('name', KEEPING)
def test_the_node_recovers(kept_stage, name):
    assert_survived(name, kept_stage)


@pytest.mark.parametrize('name', ENDING)
def test_the_wheels_stop(ending_stage, name):
    assert_survived(name, ending_stage)


@pytest.mark.parametrize('checksum', oi.Checksum)
@pytest.mark.parametrize('seed', range(3))
def test_on_a_noisy_line_only_frames_that_were_sent_are_published(seed, checksum):
    run = noise(seed, 5, checksum=checksum)
    assert not run.wrong
    assert run.kept >= LEAST_KEPT
    assert run.published > 250
    assert not run.lost


def test_a_failure_is_in_table_and_json():
    row = Row(BY_NAME['SIGKILL'], [Result(zero=0.02), Result(zero=0.3), Result(trouble='no')])
    assert '| SIGKILL | 3 | 2 | - | - | 0 | 0.160 | 0.300 |' in markdown([row])
    assert row.failures == ['zero speed after 0.300 s, not 0.1 s', 'no']
    assert [each['failure'] != '' for each in as_json([row])] == [False, True, True]
