"""The process that stops the robot when the driver has died."""

import os
import signal
import subprocess
import sys

import pytest

from create_oi_ros.dead_man import DeadMan, GOODBYE, POLITE, watch

WORDS = b'stop now'


def gone(pid: int) -> bool:
    """Tell whether a process has ended and nobody need wait for it."""
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return True
    return False


def test_released_it_writes_nothing_and_ends():
    reading, writing = os.pipe()
    dead_man = DeadMan(writing, WORDS)
    os.close(writing)
    dead_man.release()
    assert os.read(reading, 100) == b'', 'the line is closed, by it as well'
    os.close(reading)
    assert gone(dead_man.pid)


def test_releasing_one_that_was_killed_is_allowed():
    reading, writing = os.pipe()
    dead_man = DeadMan(writing, WORDS)
    os.kill(dead_man.pid, signal.SIGKILL)
    dead_man.release()
    os.close(reading)
    os.close(writing)


PARENT = """
import os, sys
from create_oi_ros.dead_man import DeadMan
dead_man = DeadMan(int(sys.argv[1]), sys.argv[2].encode())
print(dead_man.pid, flush=True)
sys.stdin.read()
"""


@pytest.mark.parametrize('number', [signal.SIGKILL, signal.SIGSEGV, signal.SIGABRT])
def test_when_its_parent_dies_it_says_the_last_words_and_ends(number):
    reading, writing = os.pipe()
    parent = subprocess.Popen(
        [sys.executable, '-c', PARENT, str(writing), WORDS.decode()], pass_fds=(writing,),
        stdin=subprocess.PIPE, stdout=subprocess.PIPE)
    os.close(writing)
    assert parent.stdout is not None
    assert parent.stdout.readline()
    parent.send_signal(number)
    heard = b''
    while more := os.read(reading, 100):
        heard += more
    assert heard == WORDS
    os.close(reading)
    parent.communicate()


def test_what_ends_its_parent_politely_does_not_reach_it():
    reading, writing = os.pipe()
    dead_man = DeadMan(writing, WORDS)
    os.close(writing)
    for number in POLITE:
        os.kill(dead_man.pid, number)
    os.close(dead_man._pipe)
    assert os.read(reading, 100) == WORDS
    os.close(reading)
    assert dead_man._process.wait() == 0


@pytest.mark.parametrize(('word', 'heard'), [(GOODBYE, b''), (b'', WORDS)])
def test_watching_ends_with_a_goodbye_or_with_last_words(word, heard):
    pipe, speaking = os.pipe()
    reading, writing = os.pipe()
    os.write(speaking, word)
    os.close(speaking)
    try:
        watch(pipe, writing, WORDS)
    finally:
        signal.alarm(0)
    os.close(writing)
    assert os.read(reading, 100) == heard
    os.close(reading)
    os.close(pipe)
