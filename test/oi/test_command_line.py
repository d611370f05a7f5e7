# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""The command line of `create_oi_ros.oi`, its page of documentation, and the examples."""

import csv
import doctest
from importlib import import_module
import io
from itertools import count
from math import degrees, hypot
from pathlib import Path
import re
import subprocess
import sys
from types import ModuleType

from hypothesis import given
from hypothesis import strategies as st
import pytest

from create_oi_ros import oi
from create_oi_ros.oi.tools.command_line import main, run
from create_oi_ros.robot import Rounding
from create_oi_ros.sim.body.config import DEFAULT_BODY
from create_oi_ros.sim.firmware.guesses import Guesses
from support.oi_strategies import frames, packet_lists
from support.robot import Robot
from support.source import ROOT

PAGE = ROOT / 'docs' / 'open_interface.md'


def ran(*arguments: str, stdin: str | bytes = '') -> tuple[int, list[str], str]:
    """Run the command line; return exit code, lines of output and errors."""
    given = stdin.encode() if isinstance(stdin, str) else stdin
    out, err = io.StringIO(), io.StringIO()
    status = main(
        list(arguments), io.TextIOWrapper(io.BytesIO(given), encoding='utf-8'), out, err)
    return status, out.getvalue().splitlines(), err.getvalue().strip()


def test_the_manuals_drive_both_ways() -> None:
    line, sent = 'Drive velocity=-200 radius=500', '137 255 56 1 244'
    assert ran('encode', line) == (0, [sent], '')
    assert ran('encode', *line.split()) == (0, [sent], '')
    assert ran('decode', sent) == (0, [line], '')
    assert ran('decode', *sent.split()) == (0, [line], '')


@pytest.mark.parametrize('arguments', [
    ['[137] [255] [56] [1] [244]'], ['137, 255, 0x38; 1 0xF4 # a note'], ['--hex', '89ff38 01:F4'],
    ['--hex', '0x89FF', '38', '1', 'f4'],
])
def test_bytes_are_read_in_several_notations(arguments: list[str]) -> None:
    assert ran('decode', *arguments) == (0, ['Drive velocity=-200 radius=500'], '')


@pytest.mark.parametrize('word', ['FF', '256', '-1', '0xfff', 'x'])
def test_a_word_that_is_not_a_byte_is_refused(word: str) -> None:
    reason = f'{word!r} is not a byte; allowed: 0 to 255, 0x00 to 0xff, or with --hex 00 to ff'
    assert ran('decode', '--', word) == (1, [], reason)
    assert ran('decode', stdin=f'128\n{word} 1\n') == (1, ['Start'], f'line 2: {reason}')


def test_commands_are_explained_and_what_is_not_understood_is_a_comment() -> None:
    status, lines, _ = ran('decode', '--explain', '131')
    assert (status, lines) == (0, [
        'Safe  # 131. Enter Safe mode: control with safety stops. Turns all LEDs off and ends '
        'charging. Obeyed in Passive, Safe, Full.'])
    status, lines, errors = ran('decode', '7 137 39 15 0 0 137')
    assert (status, errors) == (1, '')
    assert lines == [
        '# 7 is not an opcode',
        '# Drive velocity=9999 radius=0 '
        '(out of range: Drive: velocity = 9999; allowed: -500 to 500 mm/s)',
        '# Drive is cut short: 137']


def test_replies_are_explained() -> None:
    status, lines, _ = ran('decode', '3', '0', '1')
    assert status == 1 and lines[-1].endswith('read what a robot sent with --reply or --stream')
    assert ran('decode', '--reply', '7,distance,35', '3 255 254 2', '0 0 1 2') == (0, [
        'Bumps and Wheel Drops = bump_right+bump_left, Distance = -2 mm, OI Mode = safe',
        'Bumps and Wheel Drops = 0, Distance = 1 mm, OI Mode = safe'], '')
    assert ran('decode', '--reply', '19', '0') == (
        1, ['# reply is cut short: 1 of 2 bytes'], '')
    status, lines, _ = ran('decode', '--reply', '0', '3 0 1 1 1 1')
    assert (status, lines) == (1, [
        'Bumps and Wheel Drops = bump_right+bump_left, Wall = 0, Cliff Left = 1, Cliff Front Left '
        '= 1, Cliff Front Right = 1, Cliff Right = 1', '# reply is cut short: 6 of 26 bytes'])


def test_frames_are_explained_with_and_without_their_list() -> None:
    frame = '19 5 29 2 25 13 0 '
    assert ran('decode', '--stream', '29,13', frame + '182') == (0, [
        '# checksums leave the header out, as the manual says',
        'Cliff Front Left Signal = 537, Virtual Wall = 0'], '')
    assert ran('decode', '--stream', '7', '--stream', 'cliff_front_left_signal,virtual_wall',
                stdin=f'1\n{frame}\n163 19 2\n7 3 225\n19') == (1, [
        '# garbage: 1',
        '# checksums include the header, as real robots do',
        'Cliff Front Left Signal = 537, Virtual Wall = 0',
        'Bumps and Wheel Drops = bump_right+bump_left',
        '# garbage: 19'], '')
    frame += '182'
    lines = [
        '# checksums leave the header out, as the manual says', '# frames of packets 29,13',
        'Cliff Front Left Signal = 537, Virtual Wall = 0']
    assert ran('decode', '--stream', 'any', frame) == (0, lines, '')
    other = ' '.join(map(str, oi.PacketList([33]).pack_frame([512], header_in_sum=False)))
    assert ran('decode', '--stream', 'any', stdin=f'1 2\n{frame}\n{other}\n{frame}\n19 5') == (1, [
        '# garbage: 1 2', *lines, '# frames of packets 33',
        'Cargo Bay Analog Signal = 512 (2.50 V)', lines[-1], '# garbage: 19 5'], '')


@given(packet_lists().flatmap(lambda packets: st.tuples(
    st.just(packets), st.lists(frames(packets), min_size=1, max_size=3))))
def test_a_list_is_found_in_its_frames(drawn: tuple[oi.PacketList, list[bytes]]) -> None:
    packets, sent = drawn
    _, lines, _ = ran('decode', '--raw', '--stream', 'any', stdin=b''.join(sent))
    named = ','.join(map(str, packets.ids))
    assert [line for line in lines if line.startswith('# frames of packets')] == [
        f'# frames of packets {named}']


@pytest.mark.parametrize('data', [
    b'', b'\x13', b'\x13\5\xff', b'\x13\5\x1d\2\x25\x0d\0', b'\x13\5\x1d\2\x25\x0d\0\0',
    b'\x13\2\7\0\7\0', b'\x13\1\7\0', b'\x13\0\xed'])
def test_no_list_is_found_where_no_frame_is(data: bytes) -> None:
    _, lines, _ = ran('decode', '--raw', '--stream', 'any', stdin=data)
    assert not any('frames of packets' in line for line in lines)


def test_stdin_can_be_binary_and_the_boot_banner_is_shown() -> None:
    status, lines, _ = ran('decode', '--raw', '--stream', '7', stdin=b'\0RDK by iRobot!\r\n')
    assert status == 1 and len(lines) == 1
    assert lines[0].endswith(" 'RDK by iRobot!'")
    assert ran('decode', '--raw', stdin=b'\x89\xff\x38\x01\xf4\x80') == (
        0, ['Drive velocity=-200 radius=500', 'Start'], '')


def test_text_is_encoded() -> None:
    assert ran('encode', '--hex', 'Drive velocity=-200 radius=500') == (
        0, ['89 ff 38 01 f4'], '')
    assert ran('encode', stdin='# go\nSafe\nScript script={\n  Full\n}\n') == (
        0, ['131', '152 1 132'], '')
    assert ran('encode', stdin='Safe\n Drive velocity=1') == (
        1, [], 'line 2, column 2: Drive lacks radius')


def test_the_tables_are_printed() -> None:
    status, lines, _ = ran('commands')
    assert status == 0 and len(lines) == 1 + 29
    status, lines, _ = ran('packets')
    assert status == 0 and len(lines) == 1 + 36


def test_the_cost_of_a_stream_is_shown() -> None:
    status, lines, _ = ran('packets', '29', 'virtual_wall')
    assert status == 0 and [line.split()[0] for line in lines[1:3]] == ['13', '29']
    assert lines[3:] == [
        '57600 baud: a stream frame has 8 bytes and takes 1.4 ms; 86 fit in 15 ms: 78 to spare',
        '19200 baud: a stream frame has 8 bytes and takes 4.2 ms; 28 fit in 15 ms: 20 to spare']
    assert ran('packets', '6')[1][-1].endswith('28 fit in 15 ms: 28 too many')
    for arguments in (['packets'], ['decode', '--stream'], ['decode', '--reply']):
        assert ran(*arguments, '43') == (
            1, [], 'the Create has no packet 43; allowed: 0 to 42; only a Create 2 has 43')
    assert ran('packets', '60')[2] == 'the Create has no packet 60; allowed: 0 to 42'


@pytest.mark.parametrize('arguments', [[], ['frobnicate'], ['decode', '--frobnicate']])
def test_wrong_usage_has_its_own_exit_code(arguments: list[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        ran(*arguments)
    assert ended.value.code == 2


def test_the_examples_of_the_page_are_true() -> None:
    failed, tried = doctest.testfile(str(PAGE), module_relative=False, encoding='utf-8')
    assert failed == 0 and tried > 15


def test_the_shell_examples_of_the_page_are_true() -> None:
    shell = re.search(r'```\n(\$ python.*?)```', PAGE.read_text(encoding='utf-8'), re.DOTALL)
    assert shell is not None
    for example in shell[1].split('$ python -m create_oi_ros.oi ')[1:]:
        command, *output = example.splitlines()
        words = [found.strip("'") for found in re.findall(r"'[^']*'|\S+", command)]
        assert ran(*words)[1] == output


@pytest.mark.parametrize('raised, status', [(BrokenPipeError, 141), (KeyboardInterrupt, 130)])
def test_it_ends_quietly_when_stdout_is_closed_or_on_ctrl_c(
        monkeypatch: pytest.MonkeyPatch, tmp_path: Path, raised: type[BaseException],
        status: int) -> None:
    class Gone(io.StringIO):
        def write(self, text: str) -> int:
            raise raised

        def fileno(self) -> int:
            return file.fileno()

    with (tmp_path / 'stdout').open('w') as file:
        monkeypatch.setattr(sys, 'argv', ['oi', 'commands'])
        monkeypatch.setattr(sys, 'stdout', Gone())
        assert run() == status


def test_a_pipe_gets_each_line_at_once() -> None:
    with subprocess.Popen(
            [sys.executable, '-m', 'create_oi_ros.oi', 'decode'], cwd=ROOT, text=True, bufsize=1,
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        assert process.stdin and process.stdout and process.stderr
        process.stdin.write('137 255\n')
        process.stdin.write('56 1 244 128\n')
        assert process.stdout.readline() == 'Drive velocity=-200 radius=500\n'
        assert process.stdout.readline() == 'Start\n'
        process.stdout.close()
        process.stdin.write('128\n')
        process.stdin.close()
        assert process.wait(20) == 141
        assert process.stderr.read() == ''


# The examples, against a simulated robot in memory, and what their page says.


STEP = 0.005
"""Seconds that pass at once: a third of a slot."""


class Port:
    """What `serial.Serial` has, and what `time` has; time passes only while a program waits."""

    def __init__(self) -> None:
        """Lead to a simulated robot as `create_sim` has it."""
        self.robot = Robot(guesses=Guesses(boot_seconds=0), rounding=Rounding.TRUNCATE,
                           config=DEFAULT_BODY)
        self._received = b''

    def sleep(self, seconds: float) -> None:
        """Let time pass."""
        until = self.robot.now + seconds
        while self.robot.now < until - STEP / 2:
            self._received += self.robot.run(STEP)

    def monotonic(self) -> float:
        """Return the time."""
        return self.robot.now

    def write(self, data: bytes) -> None:
        """Send bytes to the robot."""
        self._received += self.robot.say(data)

    def read(self, size: int) -> bytes:
        """Wait for bytes; return fewer after a second."""
        until = self.robot.now + 1.0
        while len(self._received) < size and self.robot.now < until:
            self.sleep(STEP)
        read, self._received = self._received[:size], self._received[size:]
        return read

    @property
    def in_waiting(self) -> int:
        """The number of bytes that have arrived."""
        return len(self._received)

    def reset_input_buffer(self) -> None:
        """Forget what has arrived."""
        self._received = b''

    def example(self, name: str) -> ModuleType:
        """Return an example whose time is that of the robot."""
        module = import_module(f'examples.{name}')
        module.time = self  # type: ignore[attr-defined]
        return module


@pytest.fixture
def port() -> Port:
    return Port()


def test_the_square_ends_where_it_began(port, capsys):
    port.example('oi_square').main(port)
    truth = port.robot.body.truth()
    assert hypot(truth.pose.x, truth.pose.y) < 0.05
    assert abs(truth.pose.yaw) < 0.2
    assert truth.travelled == pytest.approx(4 * 0.5, rel=0.02)
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) == 4
    for line in lines:
        distance, angle = map(int, re.findall(r'(\d+) (?:mm|degrees)', line))
        assert distance == pytest.approx(500, abs=10) and angle == pytest.approx(90, abs=5)
    assert (port.robot.mode, port.robot.wheels) == (oi.Mode.PASSIVE, (0, 0))


@pytest.mark.parametrize('name', ['oi_square', 'oi_script'])
def test_an_answer_with_lost_bytes_is_asked_for_again(port, name):
    example = port.example(name)
    read, asked = port.read, count()
    port.read = lambda size: read(size)[:-1 if next(asked) % 2 == 0 else None]
    example.main(port)
    assert port.robot.body.truth().travelled > 0.25
    assert port.robot.wheels == (0, 0)


def test_the_log_ends_where_no_frame_comes(port):
    port.write = lambda data: None  # the robot is off
    with pytest.raises(SystemExit, match='no frame for 3 s: is the robot switched on'):
        port.example('oi_log').log(port, io.StringIO(newline=''))


@pytest.mark.parametrize('name', ['oi_log', 'square'])
def test_an_example_has_help_and_says_what_is_wrong_with_its_arguments(name, tmp_path):
    def run(*arguments):
        return subprocess.run(
            [sys.executable, str(ROOT / 'examples' / f'{name}.py'), *arguments], text=True,
            capture_output=True, timeout=60, cwd=tmp_path)
    shown = run('--help')
    assert (shown.returncode, shown.stderr) == (0, '') and 'usage' in shown.stdout
    assert run('--bogus').returncode == 2
    if name.startswith('oi_'):
        assert run().returncode == 2
        ended = run('/dev/nothing', *(['log.csv'] if name == 'oi_log' else []))
        assert ended.returncode == 1
        line, = ended.stderr.splitlines()
        assert 'No such file' in line and line.endswith(
            'is the cable in, and are you in the group dialout?')


def test_the_log_has_a_row_for_each_frame(port):
    port.robot.body.force(analog=512)
    file = io.StringIO(newline='')
    example = port.example('oi_log')
    example.log(port, file, 100)
    rows = list(csv.DictReader(io.StringIO(file.getvalue())))
    assert len(rows) == 100
    assert rows[0].keys() == {'seconds', 'analog_volts', *example.PACKETS.names}
    assert {row['oi_mode'] for row in rows} == {'1'}
    assert {(row['analog_signal'], row['analog_volts']) for row in rows} == {('512', '2.502')}
    assert float(rows[-1]['seconds']) - float(rows[0]['seconds']) == pytest.approx(99 * oi.SLOT)
    port.sleep(1.0)
    port.reset_input_buffer()
    port.sleep(1.0)
    assert port.in_waiting == 0  # the stream is paused


def test_the_script_is_stored_and_played_to_its_end(port, capsys):
    example = port.example('oi_script')
    example.main(port)
    pose = port.robot.body.truth().pose
    assert pose.x == pytest.approx(0.3, abs=0.1) and degrees(pose.yaw) == pytest.approx(90, abs=15)
    assert capsys.readouterr().out.splitlines()[:3] == [
        'the script can end',
        'until this has happened, even a stop is ignored: Wait Distance distance=300',
        'until this has happened, even a stop is ignored: Wait Angle angle=90']
    assert (port.robot.mode, port.robot.wheels) == (oi.Mode.PASSIVE, (0, 0))
