"""The fault campaign in its short form: a few faults, once each; `make faults` does them all."""

from random import Random

import pytest

from campaign.cases import FAULTS, Outcome
from campaign.faults import attempt
from campaign.noise import LEAST_KEPT, noise
from campaign.stage import staged
from campaign.table import as_json, markdown, Row
from create_oi_ros import oi

BY_NAME = {fault.name: fault for fault in FAULTS}
LASTING = ('cable out and in', 'robot off and on', 'robot deaf for a while',
           'bad line: 5 % flipped, short, garbage', 'all bytes garbled', 'commands end', 'stop',
           'robot told to wait for ever', 'SIGSTOP, SIGCONT')
ENDING = ('command cut short before connecting', 'SIGKILL', 'SIGTERM',
          'exception on the serial thread')
PATIENCE = 5.0
"""How much longer things may take here than on a quiet machine."""


@pytest.fixture(scope='module')
def lasting_stage(tmp_path_factory):
    """Return a stage that goes on from fault to fault."""
    with staged(tmp_path_factory.mktemp('stage')) as made:
        yield made


@pytest.fixture(scope='module')
def ending_stage(tmp_path_factory):
    """Return a stage whose node ends with every fault."""
    with staged(tmp_path_factory.mktemp('stage')) as made:
        yield made


def assert_survived(name, stage):
    """Make a fault once; nothing must be wrong."""
    row = Row(BY_NAME[name], patience=PATIENCE)
    outcome = attempt(row.fault, stage, Random(name))
    node = stage.node.output if stage.node is not None else ''
    assert not row.fails(outcome), node


@pytest.mark.parametrize('name', LASTING)
def test_it_goes_on(lasting_stage, name):
    assert_survived(name, lasting_stage)


@pytest.mark.parametrize('name', ENDING)
def test_the_wheels_stop(ending_stage, name):
    assert_survived(name, ending_stage)


@pytest.mark.parametrize('checksum', oi.Checksum)
@pytest.mark.parametrize('seed', range(3))
def test_on_a_bad_line_what_is_published_was_sent(seed, checksum):
    heard = noise(seed, 5, checksum=checksum)
    assert not heard.wrong
    assert heard.kept >= LEAST_KEPT
    assert heard.published > 250
    assert not heard.lost


def test_a_failure_is_in_table_and_json():
    row = Row(BY_NAME['SIGKILL'], [Outcome(zero=0.02), Outcome(zero=0.3), Outcome(trouble='no')])
    assert '| SIGKILL | 3 | 2 | - | - | 0 | 0.160 | 0.300 |' in markdown([row])
    assert row.failures == ['zero speed after 0.300 s, not 0.1 s', 'no']
    assert [each['failure'] != '' for each in as_json([row])] == [False, True, True]
