# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""The process that stops the robot when the driver has died."""

from collections.abc import Iterator
from contextlib import suppress
from functools import partial
from math import inf
import os
import pty
import signal
import subprocess
import sys
import threading
import tty
from types import SimpleNamespace

import pytest

from create_oi_ros.link import dead_man_process
from create_oi_ros.link.dead_man import DeadMan, END_SIGNALS
from create_oi_ros.link.dead_man_process import GOODBYE, watch
from support.processes import dead_man, dead_men

WORDS = b'stop now'


def read_words(reading: int) -> bytes:
    """Wait for as many bytes as the last words have."""
    return b''.join(os.read(reading, 1) for _ in WORDS)


@pytest.fixture
def guarded() -> Iterator[tuple[DeadMan, int]]:
    """Yield a dead-man and the other end of its line."""
    reading, writing = os.pipe()
    guard = DeadMan(writing, WORDS)
    os.close(writing)
    yield guard, reading
    os.close(reading)


def test_released_it_writes_nothing_and_ends(guarded):
    guard, reading = guarded
    guard.release()
    assert os.read(reading, 100) == b'', 'the line is closed, by it as well'
    assert not dead_men()


def test_one_that_cannot_be_started_leaves_no_file_open(monkeypatch):
    monkeypatch.setattr(sys, 'executable', '/nowhere/python')
    before = os.listdir('/proc/self/fd')
    for _ in range(10):
        with pytest.raises(FileNotFoundError):
            DeadMan(0, WORDS)
    assert os.listdir('/proc/self/fd') == before


PARENT = """
import os, sys
from create_oi_ros.link.dead_man import DeadMan
dead_man = DeadMan(int(sys.argv[1]), sys.argv[2].encode())
print('guarded', flush=True)
sys.stdin.read()
"""


def test_when_its_parent_is_suspended_and_when_it_dies_it_says_the_last_words():
    reading, writing = os.pipe()
    parent = subprocess.Popen(
        [sys.executable, '-c', PARENT, str(writing), WORDS.decode()], pass_fds=(writing,),
        stdin=subprocess.PIPE, stdout=subprocess.PIPE)
    os.close(writing)
    try:
        assert parent.stdout.readline()
        parent.send_signal(signal.SIGSTOP)
        assert read_words(reading) == WORDS
        parent.kill()
        rest = b''.join(iter(partial(os.read, reading, 100), b''))  # until all have closed it
        assert rest == WORDS
    finally:
        parent.kill()
        parent.communicate()
        os.close(reading)


@pytest.mark.parametrize(('suspended', 'spoken'), [
    ([(1.05, inf)], [1.12, 2.12, 3.12, 4.12]), ([(1.05, 1.5), (2.05, 2.5)], [1.12, 2.14]),
    ([(1.05, 1.11), (2.05, 2.11)], [])])
def test_a_parent_that_is_suspended_for_two_looks_is_spoken_for_at_once_and_each_second(
        monkeypatch, suspended, spoken):
    """At most 0.2 s after it was suspended, as docs/reliability.md promises."""
    now, spoken_at, looks = 0.0, [], []

    def wait(reading, writing, failing, timeout):
        nonlocal now
        now += timeout
        looks.append(now)
        return (reading if now > 4.5 else [], writing, failing)
    pipe, speaking = os.pipe()
    os.write(speaking, GOODBYE)
    monkeypatch.setattr(dead_man_process, 'select', SimpleNamespace(select=wait))
    monkeypatch.setattr(dead_man_process, 'is_suspended', lambda _: any(
        begin <= now < end for begin, end in suspended))
    monkeypatch.setattr(
        dead_man_process, 'write_all', lambda line, words: spoken_at.append(now))
    watch(pipe, -1, WORDS, os.getpid())
    assert sum(look < 1.0 for look in looks) <= 10, 'looks cost time on the processor'
    assert spoken_at == pytest.approx(spoken)
    os.close(pipe)
    os.close(speaking)


def test_a_line_that_is_gone_ends_the_last_words():
    reading, writing = os.pipe()
    os.close(reading)
    dead_man_process.write_all(writing, WORDS)
    os.close(writing)


@pytest.mark.parametrize('blocking', [True, False])
def test_a_line_that_takes_no_bytes_ends_the_process(monkeypatch, blocking):
    monkeypatch.setattr(dead_man_process, 'WRITE_TIMEOUT', 0.0)
    reading, writing = os.pipe()
    os.set_blocking(writing, False)
    with suppress(BlockingIOError):
        while os.write(writing, bytes(4096)):
            pass
    os.set_blocking(writing, blocking)
    with pytest.raises(SystemExit) as ended:
        dead_man_process.write_all(writing, WORDS)
    assert ended.value.code == 1
    os.close(reading)
    os.close(writing)


@pytest.mark.parametrize('blocking', [True, False])
def test_a_line_with_little_room_gets_each_byte_once(blocking):
    ours, theirs = pty.openpty()
    tty.setraw(theirs)
    os.set_blocking(theirs, blocking)
    words = bytes(range(256)) * 64  # more than the terminal takes at once
    heard = bytearray()

    def hear() -> None:
        while len(heard) < len(words):
            heard.extend(os.read(ours, 64))
    hearing = threading.Thread(target=hear)
    hearing.start()
    dead_man_process.write_all(theirs, words)
    hearing.join()
    assert heard == words
    os.close(ours)
    os.close(theirs)


def test_what_ends_its_parent_politely_does_not_reach_it(guarded):
    guard, reading = guarded
    pid = dead_man()
    assert os.getsid(pid) == pid, 'the keys of a terminal do not reach it'
    for number in END_SIGNALS:
        os.kill(pid, number)
    guard.trigger()
    assert read_words(reading) == WORDS
    assert guard.ended


@pytest.mark.parametrize(('word', 'heard'), [(GOODBYE, b''), (b'', WORDS), (b'x', WORDS)])
def test_watching_ends_with_a_goodbye_or_with_last_words(word, heard):
    pipe, speaking = os.pipe()
    reading, writing = os.pipe()
    os.write(speaking, word)
    os.close(speaking)
    watch(pipe, writing, WORDS, os.getpid())
    os.close(writing)
    assert os.read(reading, 100) == heard
    os.close(reading)
    os.close(pipe)
