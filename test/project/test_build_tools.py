# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Set-up and build: what they say, and where they put what they make."""

import importlib.util
import os
import subprocess
import sys

import pytest

from support.source import ROOT

TOOLS = ROOT / 'tools'


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


def test_a_step_that_fails_shows_the_end_of_its_log(tmp_path):
    code = f'import sys; sys.path.insert(0, {str(TOOLS)!r}); from step import step; step(' \
           '[sys.executable, "-c", "print(\'the cause\'); raise SystemExit(3)"], "a.log", ' \
           '"it failed", progress=str)'
    done = subprocess.run([sys.executable, '-c', code], cwd=tmp_path, text=True,
                          capture_output=True)
    assert (done.returncode, done.stdout) == (1, '')
    assert done.stderr == 'the cause\nmake: it failed (complete log: log/a.log)\n'


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
