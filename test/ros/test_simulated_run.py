# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""A simulated run has a ROS domain and a folder to itself, and leaves nothing behind."""

import os
import subprocess
import sys
import tempfile

import pytest

from create_oi_ros.ros import simulated_run
from create_oi_ros.ros.programs import UserError
from create_oi_ros.ros.simulated_run import run_domain, run_folder


@pytest.fixture(autouse=True)
def no_domain(monkeypatch):
    """Unset ROS_DOMAIN_ID; whatever a test sets is undone."""
    monkeypatch.setenv('ROS_DOMAIN_ID', '')
    monkeypatch.setenv('ROS_AUTOMATIC_DISCOVERY_RANGE', 'SUBNET')
    monkeypatch.delenv('ROS_DOMAIN_ID')
    monkeypatch.delenv('ROS_AUTOMATIC_DISCOVERY_RANGE')
    return monkeypatch


def test_two_runs_have_different_domains(no_domain):
    with run_domain() as first:
        assert os.environ['ROS_DOMAIN_ID'] == first
        assert os.environ['ROS_AUTOMATIC_DISCOVERY_RANGE'] == 'LOCALHOST'
        no_domain.delenv('ROS_DOMAIN_ID')
        with run_domain() as second:
            assert second != first


def test_a_domain_that_is_set_is_kept(no_domain):
    no_domain.setenv('ROS_DOMAIN_ID', '7')
    with run_domain() as domain:
        assert domain == '7'
        assert 'ROS_AUTOMATIC_DISCOVERY_RANGE' not in os.environ


def test_a_domain_is_free_again_after_its_run(no_domain):
    no_domain.setattr(simulated_run, 'DOMAINS', range(228, 229))
    for _ in range(2):
        with run_domain() as domain:
            assert domain == '228'
            no_domain.delenv('ROS_DOMAIN_ID')


def test_when_all_domains_are_taken_it_says_so(no_domain):
    no_domain.setattr(simulated_run, 'DOMAINS', range(229, 230))
    with run_domain():
        no_domain.delenv('ROS_DOMAIN_ID')
        with pytest.raises(UserError, match='choose a domain yourself with ROS_DOMAIN_ID'):
            with run_domain():
                pass


def dead_process() -> int:
    """Return the id of a process that has ended."""
    done = subprocess.Popen([sys.executable, '-c', ''])
    done.wait()
    return done.pid


def test_folders_of_dead_processes_are_removed_and_no_others(tmp_path, monkeypatch):
    monkeypatch.setattr(tempfile, 'tempdir', str(tmp_path))
    dead = tmp_path / f'create-{dead_process()}-abc_123'
    kept = [tmp_path / name for name in (
        f'create-{os.getppid()}-abc', 'create-me-now', 'create-12', 'create-oi', 'create')]
    for folder in (dead, *kept):
        folder.mkdir()
    (dead / 'create').symlink_to('/dev/pts/99')
    with run_folder() as own:
        assert own.name.startswith(f'create-{os.getpid()}-')
        assert not dead.exists()
        assert all(folder.exists() for folder in kept)
    assert not own.exists()
