# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Scripts and the text form of commands: the manual's examples, round trips, errors."""

from hypothesis import given
from hypothesis import strategies as st
import pytest

from create_oi_ros import oi
from create_oi_ros.oi.script import (
    build_script,
    can_end,
    commands_of,
    open_waits,
    SCRIPT_LIMIT,
)
from create_oi_ros.oi.tools.text import (
    format_command,
    parse_commands,
    parse_script,
    TextError,
)
from create_oi_ros.oi.tools.tunes import note_name, note_number
from support.oi_strategies import commands
import vectors

TEXTS = {
    'Drive 40 cm and stop': """\
Drive velocity=300 radius=straight
Wait Distance distance=400
Drive velocity=0 radius=0
""",
    'Toggle led on bump': """\
Wait Event event=bump
Wait Event event=not_bump
LEDs bits=play color=0 intensity=0
Wait Event event=bump
Wait Event event=not_bump
LEDs bits=0 color=0 intensity=0
Play Script
""",
    'Drive in a square': """\
Drive velocity=300 radius=straight
Wait Distance distance=400
Drive velocity=300 radius=in_place_counter_clockwise
Wait Angle angle=90
Play Script
""",
}


@pytest.mark.parametrize('name, listed, sent', vectors.SCRIPTS, ids=lambda value: str(value)[:20])
def test_the_manuals_scripts_come_out_byte_for_byte(
        name: str, listed: list[oi.Command], sent: bytes) -> None:
    script = build_script(listed)
    assert script.encode() == sent
    assert commands_of(script) == listed
    assert ''.join(f'{format_command(each)}\n' for each in listed) == TEXTS[name]
    assert parse_script(TEXTS[name]).encode() == sent
    assert parse_commands(format_command(script)) == [script]


def test_a_script_that_plays_itself_cannot_end_and_waits_that_may_not_are_named() -> None:
    assert [can_end(parse_script(text)) for text in TEXTS.values()] == [True, False, False]
    assert can_end(oi.Script(script=b''))
    assert not can_end(oi.Script(script=bytes([7, 153, 137, 0])))
    assert can_end(oi.Script(script=bytes([151, 153]))), 'the 153 is data of Send IR'
    script = parse_script(TEXTS['Drive in a square'] + 'Wait Time time=5\nWait Event event=bump')
    assert open_waits(script) == [
        oi.WaitDistance(distance=400), oi.WaitAngle(angle=90), oi.WaitEvent(event=5)]


def test_a_script_longer_than_the_robot_can_store_is_refused() -> None:
    full = [oi.WaitTime(time=1)] * (SCRIPT_LIMIT // 2)
    assert len(build_script(full).encode()) == 102
    with pytest.raises(ValueError) as refused:
        build_script([*full, oi.Safe()])
    assert str(refused.value) == (
        'Script: command 51 (Safe) brings it to 101 bytes; allowed: 100 bytes')
    with pytest.raises(ValueError, match='Drive: velocity = 900'):
        build_script([oi.Drive(velocity=900, radius=0)])


@pytest.mark.parametrize('script, message', [
    (b'\x07', 'Script: 7 is not an opcode'),
    (b'\x80\x89\x01', 'Script: its last command, Drive, is cut short'),
])
def test_bytes_that_are_not_commands_are_refused(script: bytes, message: str) -> None:
    with pytest.raises(ValueError) as refused:
        commands_of(oi.Script(script=script))
    assert str(refused.value) == message


def test_notes_are_the_manuals() -> None:
    for number, (letter, frequency) in vectors.NOTES.items():
        name = note_name(number)
        assert name[:-1] == letter and note_number(name) == number
        equal_tempered = 440 * 2 ** ((number - note_number('A4')) / 12)
        assert number == 32 or abs(equal_tempered / frequency - 1) < 0.001
    assert (note_name(60), note_name(31), note_name(127)) == ('C4', 'G1', 'G9')


@pytest.mark.parametrize('name, number', [
    ('c#4', 61), ('Db4', 61), ('DB4', 61), ('b3', 59), ('bb3', 58), ('Cb4', 59), ('g1', 31)])
def test_notes_are_read_as_musicians_write_them(name: str, number: int) -> None:
    assert note_number(name) == number


@pytest.mark.parametrize('name', ['H4', 'C', 'C##4', 'C-1', 'F#1', 'G#9', ''])
def test_a_name_of_no_sounding_note_is_refused(name: str) -> None:
    with pytest.raises(ValueError):
        note_number(name)
    for number in (30, 128):
        with pytest.raises(ValueError, match=r'makes no sound; allowed: 31 \(G1\) to 127 \(G9\)'):
            note_name(number)


@given(commands())
def test_parsing_a_formatted_command_returns_it(command: oi.Command) -> None:
    text = format_command(command)
    assert '\n' not in text
    assert parse_commands(text) == [command]
    assert parse_commands(f'  {text} ;\n\n# {text}\n{text} # {text}') == [command, command]


@pytest.mark.parametrize('text, sent', [
    ('drive VELOCITY = -200  radius= 500', '137 255 56 1 244'),
    ('Drive velocity=0xc8 radius=in-place-clockwise', '137 0 200 255 255'),
    ('Drive velocity=+200 radius=-0x1', '137 0 200 255 255'),
    ('pause/resume stream state=pause', '150 0'),
    ('PauseResumeStream state=1', '150 1'),
    ('Wait Event event=-bump', '158 251'),
    ('Wait Event event=not-bump', '158 251'),
    ('Wait Event event=NotBump', '158 251'),
    ('Wait Event event=!bump', '158 251'),
    ('Wait Event event=-5', '158 251'),
    ('Demo demo=abort', '136 255'),
    ('Baud code=57600', '129 10'),
    ('Baud code=10', '129 10'),
    ('LEDs bits=play|advance color=0 intensity=128', '139 10 0 128'),
    ('LEDs bits=8 color=0 intensity=128', '139 8 0 128'),
    ('LEDs bits=advance+8 color=0 intensity=128', '139 8 0 128'),
    ('Digital Outputs bits=output_0+output-2', '147 5'),
    ('Stream packets=29,virtual_wall', '148 2 29 13'),
    ('Stream packets=cliff-front-left-signal,\n  VirtualWall', '148 2 29 13'),
    ('Stream packets=', '148 0'),
    ('Sensors packet=6', '142 6'),
    ('Song number=2 notes=C4:64, rest:16, 127:255', '140 2 3 60 64 0 16 127 255'),
    ('Song number=15 notes=G1:32', '140 15 1 31 32'),
    ('Song notes=30:0x20 number=15', '140 15 1 30 32'),
    ('Script script=128,7', '152 2 128 7'),
    ('Script script={}', '152 0'),
    ('Script script={ # nothing\n}', '152 0'),
    ('Script script={Script script={Full; Safe;}\nStart}', '152 5 152 2 132 131 128'),
])
def test_variants_of_the_text_form_are_parsed(text: str, sent: str) -> None:
    command, = parse_commands(text)
    assert command.encode() == vectors.octets(sent)


@pytest.mark.parametrize('command, text', [
    (oi.Drive(velocity=9999, radius=1), 'Drive velocity=9999 radius=in_place_counter_clockwise'),
    (oi.Leds(bits=255, color=1, intensity=2), 'LEDs bits=255 color=1 intensity=2'),
    (oi.WaitEvent(event=-100), 'Wait Event event=-100'),
    (oi.Song(number=99, notes=()), 'Song number=99 notes='),
    (oi.Song(number=0, notes=(oi.Note(30, 1),)), 'Song number=0 notes=30:1'),
    (oi.Script(script=bytes([137, 39, 15, 0, 0])), 'Script script=137,39,15,0,0'),
])
def test_commands_out_of_range_can_be_formatted(command: oi.Command, text: str) -> None:
    assert format_command(command) == text


@pytest.mark.parametrize('text, line, column, reason', [
    ('Full\n  Drve velocity=3', 2, 3,
     "'Drve' is not a command; did you mean Drive?"),
    ('Full now', 1, 1, "'Full now' is not a command; did you mean Full?"),
    ('waitangel angle=90', 1, 1,
     "'waitangel' is not a command; did you mean Wait Angle, Wait Distance?"),
    ('Drive 200 straight', 1, 1, "'Drive 200 straight' is not a command; "
     'did you mean Drive velocity=... radius=...?'),
    ('garbage', 1, 1, "'garbage' is not a command; allowed: Start, Baud, "),
    ('x', 1, 1, "'x' is not a command; allowed: Start, Baud, "),
    ('=', 1, 1, "'=' is not a command; allowed: Start, Baud, "),
    ('Full;}', 1, 6, "'}' is not a command; allowed: Start, "),
    ('Full}', 1, 5, "'}' is not a command; allowed: Start, "),
    ('Script script={Full} Full', 1, 22, 'Script: expected name=value or line end'),
    ('Song notes= number=1', 1, 1, 'Song: notes has 0 notes; allowed: 1 to 16 notes'),
    ('Drive velocity=900 radius=0', 1, 16,
     'Drive: velocity = 900; allowed: -500 to 500 mm/s'),
    ('Drive velocity=1 radius=left', 1, 25,
     'Drive: radius = left; allowed: -2000 to 2000 mm, -32768 STRAIGHT, 32767 STRAIGHT_7FFF; '
     'or straight, straight_7fff, in_place_clockwise, in_place_counter_clockwise'),
    ('Drive velocity=3', 1, 1, 'Drive lacks radius'),
    ('Drive', 1, 1, 'Drive lacks velocity, radius'),
    ('Drive velocity=3 4 radius=3', 1, 18, 'Drive: expected name=value or line end'),
    ('Drive velocity=3,4 radius=3', 1, 16,
     'Drive: velocity needs one value; allowed: -500 to 500 mm/s'),
    ('Wait Time time=', 1, 16, 'Wait Time: time needs one value; allowed: 0 to 255 (1/10 s)'),
    ('Wait Time time=9999999999', 1, 16, 'Wait Time: time = 9999999999; allowed: '),
    ('Drive speed=3', 1, 7, 'Drive has no field speed; allowed: velocity, radius'),
    ('Full speed=3', 1, 6, 'Full has no field speed; allowed: none'),
    ('Drive velocity=1\tVelocity=2', 1, 18, 'Drive: velocity is given twice'),
    ('Baud code=1234', 1, 11, 'Baud: code = 1234; allowed: 0 to 11; or 300, 600, '),
    ('Demo demo=-cover', 1, 11, 'Demo: demo = -cover; allowed: -1 to 9; or abort, cover, '),
    ('Wait Event event=not_me', 1, 18, 'Wait Event: event = not_me; allowed: '),
    ('Wait Event event=0', 1, 18,
     'Wait Event: event = 0; allowed: -22 to 22 (negative for the inverse), but not 0'),
    ('LEDs bits=play+red color=0 intensity=0', 1, 11,
     'LEDs: bits = play+red; allowed: a sum of 2 PLAY, 8 ADVANCE'),
    ('Stream packets=7,99', 1, 18,
     'Stream: packets[1] = 99; allowed: 0 to 42 or a name such as bumps_and_wheel_drops'),
    ('Stream packets=unused', 1, 16, 'Stream: packets[0] = unused; allowed: 0 to 42 or a name'),
    ('Song number=0 notes=', 1, 1, 'Song: notes has 0 notes; allowed: 1 to 16 notes'),
    ('Song number=0 notes=C4:1,H4:1', 1, 26,
     "Song: notes: 'H4' is not a note; allowed: names such as C4, C#4 or Db4"),
    ('Song number=0 notes=C4', 1, 21, 'Song: notes = C4; allowed: note:duration'),
    ('Song number=0 notes=C4:999', 1, 24, 'Song: notes, duration = 999; allowed: 0 to 255 ('),
    ('Song number=0 notes=C4:1,C#4:999', 1, 30, 'Song: notes, duration = 999; allowed: 0'),
    ('Song number=0 notes=300:9', 1, 21, 'Song: notes, note = 300; allowed: 0 to 255'),
    ('Song number=0 notes=F#1:9', 1, 21, 'Song: notes: F#1 makes no sound; allowed: 31 (G1) to '),
    ('Start\nScript script={\nFull\nDrive velocity=x}', 4, 16, 'Drive: velocity = x; allowed: '),
    ('Script script={Full', 1, 15, 'this { is never closed'),
    ('Script script={' + 'Drive velocity=300 radius=1;' * 21 + '}', 1, 15,
     'Script: command 21 (Drive) brings it to 105 bytes; allowed: 100 bytes'),
    ('Script script={' * 60, 1, 50 * 15 + 15, 'Script: scripts are nested more than 50 deep'),
])
def test_an_error_names_line_column_and_what_is_allowed(
        text: str, line: int, column: int, reason: str) -> None:
    with pytest.raises(TextError) as refused:
        parse_commands(text)
    assert str(refused.value).startswith(f'line {line}, column {column}: {reason}')


WORDS = st.sampled_from([
    'Drive', 'velocity', 'radius', 'Script', 'script', '=', '{', '}', '#', ';', '\n', ' ', ',',
    '-', '5', '0x', 'straight', 'Song', 'notes', 'C#4:32', ':', 'LEDs', 'bits', '+', 'not_', 'ß'])


@given(st.lists(WORDS).map(''.join) | st.text())
def test_any_text_is_parsed_or_raises_a_text_error(text: str) -> None:
    try:
        found = parse_commands(text)
    except TextError:
        return
    assert parse_commands('; '.join(map(format_command, found))) == found
