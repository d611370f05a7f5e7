# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Set-up and build: what they show meanwhile, and where they put what they make."""

import importlib.util
import os
import signal
import subprocess
import sys

import pytest

from support.source import ROOT

TOOLS = ROOT / 'tools'
WAITING = 'print("done", flush=True)\nopen("go").read()\n'
"""A program that waits until the test writes to the pipe `go`."""
STEP = """
import sys
sys.path.insert(0, {tools!r})
import step
with step.interruptible():
    step.step([sys.executable, '-c', {program!r}], 'a.log', 'it failed',
              progress=lambda log: str(log.count('done')) + ' of 2 done')
"""


@pytest.fixture
def tool(monkeypatch):
    """Return a function that imports a file of tools/."""
    def load(name):
        monkeypatch.syspath_prepend(TOOLS)
        monkeypatch.delitem(sys.modules, 'step', raising=False)
        spec = importlib.util.spec_from_file_location(name, TOOLS / f'{name}.py')
        module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
        return module
    return load


def run_step(folder, program, stdout):
    """Start a step in a folder."""
    os.mkfifo(folder / 'go')
    code = STEP.format(tools=str(TOOLS), program=program)
    return subprocess.Popen(
        [sys.executable, '-c', code], cwd=folder, stdout=stdout, stderr=subprocess.PIPE,
        text=True, env={**os.environ, 'TERM': 'xterm'})


def test_a_terminal_shows_how_far_a_step_is_and_for_how_long(tmp_path):
    master, slave = os.openpty()
    with run_step(tmp_path, WAITING, slave) as process:
        os.close(slave)
        shown = b''
        while b'\r  1 of 2 done, 0:0' not in shown:
            shown += os.read(master, 100)
        (tmp_path / 'go').write_text('')
        assert process.wait(20) == 0
    os.set_blocking(master, False)
    shown += os.read(master, 10000)
    os.close(master)
    assert b'\x1b' not in shown and b'\n' not in shown
    assert shown.endswith(b' \r')  # the line is cleared


def test_a_step_that_fails_shows_the_end_of_its_log(tmp_path):
    with run_step(tmp_path, 'print("the cause"); raise SystemExit(3)', subprocess.PIPE) as process:
        _, errors = process.communicate(timeout=20)
    assert errors == 'the cause\nmake: it failed (complete log: log/a.log)\n'
    assert process.returncode == 1


def test_ctrl_c_of_a_step_is_one_sentence(tmp_path):
    with run_step(tmp_path, WAITING, subprocess.PIPE) as process:
        log = tmp_path / 'log' / 'a.log'
        while not log.exists() or not log.read_text():
            assert process.poll() is None
        process.send_signal(signal.SIGINT)
        (tmp_path / 'go').write_text('')
        _, errors = process.communicate(timeout=20)
    assert errors == '\nmake: interrupted; make again begins with what is not complete\n'


def test_messages_are_built_anew_when_one_was_removed(tool, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    built = tmp_path / 'install/create_oi_msgs/share/create_oi_msgs'
    for folder in (tmp_path / 'msg_defs', built):
        for name in ('msg/Song.msg', 'srv/Stop.srv', 'action/Dock.action'):
            (folder / name).parent.mkdir(parents=True)
            (folder / name).touch()
    (tmp_path / 'build/create_oi_msgs').mkdir(parents=True)
    tool('build').forget_removed()
    assert built.exists()
    (tmp_path / 'msg_defs/srv/Stop.srv').unlink()
    tool('build').forget_removed()
    assert not built.exists()
    assert not (tmp_path / 'build/create_oi_msgs').exists()


@pytest.mark.parametrize('name', ['a b', 'ümlaut', 'a;b', '$HOME'])
def test_what_is_made_for_a_special_path_is_elsewhere(tool, tmp_path, monkeypatch, name):
    clone, cache = tmp_path / name, tmp_path / 'cache'
    clone.mkdir()
    monkeypatch.chdir(clone)
    monkeypatch.setenv('XDG_CACHE_HOME', str(cache))
    folders = tool('folders')
    folders.make_anew()
    (clone / 'build' / 'old').touch()
    folders.make_anew()
    for each in ('.venv', 'build', 'install'):
        real = (clone / each).resolve()
        assert real.is_dir() and not list(real.iterdir())
        assert folders.is_plain(real) and cache in real.parents
    done = subprocess.run(['make', '-f', ROOT / 'Makefile', 'clean'], cwd=clone, check=False)
    assert done.returncode == 0
    assert not list(clone.iterdir()) and not list(cache.iterdir())


@pytest.mark.parametrize('name, sentence', [
    ('a b', 'set XDG_CACHE_HOME to a folder whose path has none'),
    ("it's", 'make cannot work in a path with a quote')])
def test_a_path_in_which_nothing_can_be_built_is_refused_in_one_line(tmp_path, name, sentence):
    folder = tmp_path / name
    folder.mkdir()
    done = subprocess.run(
        [sys.executable, TOOLS / 'check.py', 'jazzy'], cwd=folder, text=True, check=False,
        capture_output=True, env={**os.environ, 'XDG_CACHE_HOME': str(folder)})
    assert (done.returncode, done.stderr, done.stdout.count('\n')) == (1, '', 1)
    assert sentence in done.stdout and str(folder) in done.stdout.replace('\\', '')
