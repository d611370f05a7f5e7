# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Scripts and the text form of commands: the manual's examples, round trips, errors."""

from fractions import Fraction

from hypothesis import given
from hypothesis import strategies as st
import pytest

from create_oi_ros import oi
from create_oi_ros.oi.commands import REST, SOUNDING
from create_oi_ros.oi.script import (
    build_script,
    can_end,
    commands_of,
    duration,
    endless_wait,
    open_waits,
    SCRIPT_LIMIT,
)
from create_oi_ros.oi.tools.text import (
    format_command,
    parse_commands,
    parse_script,
    TextError,
)
from create_oi_ros.oi.tools.tunes import note_name, note_number, note_text, parse_tune
from create_oi_ros.robot import FIRMWARE_SEPARATION, MM_PER_M
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
    with pytest.raises(TextError, match='brings it to 102 bytes; allowed: 100 bytes'):
        parse_script('Wait Time time=1\n' * 51)
    with pytest.raises(TextError, match='has 10001 characters; allowed: 10000'):
        parse_script('#' * 10001)
    assert parse_script('#' * 10000) == oi.Script(script=b'')
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
    ('Wait Event event=!bump', '158 251'),
    ('Wait Event event=-5', '158 251'),
    ('Demo demo=abort', '136 255'),
    ('Baud code=57600', '129 10'),
    ('LEDs bits=play|advance color=0 intensity=128', '139 10 0 128'),
    ('LEDs bits=advance+8 color=0 intensity=128', '139 8 0 128'),
    ('Digital Outputs bits=output_0+output-2', '147 5'),
    ('Stream packets=29,virtual_wall', '148 2 29 13'),
    ('Stream packets=cliff-front-left-signal,\n  VirtualWall', '148 2 29 13'),
    ('Stream packets=', '148 0'),
    ('Song number=2 notes=C4:64, rest:16, 127:255', '140 2 3 60 64 0 16 127 255'),
    ('Song notes=30:0x20 number=15', '140 15 1 30 32'),
    ('Script script=128,7', '152 2 128 7'),
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
    ('waitangel angle=90', 1, 1,
     "'waitangel' is not a command; did you mean Wait Angle, Wait Distance?"),
    ('Drive 200 straight', 1, 1, "'Drive 200 straight' is not a command; "
     'did you mean Drive velocity=... radius=...?'),
    ('Full}', 1, 5, "'}' is not a command; allowed: Start, "),
    ('Script script={Full} Full', 1, 22, 'Script: expected name=value or line end'),
    ('Song notes= number=1', 1, 1, 'Song: notes has 0 notes; allowed: 1 to 16 notes'),
    ('Drive velocity=900 radius=0', 1, 16,
     'Drive: velocity = 900; allowed: -500 to 500 mm/s'),
    ('Drive velocity=1 radius=left', 1, 25,
     'Drive: radius = left; allowed: -2000 to 2000 mm, -32768 STRAIGHT, 32767 STRAIGHT_7FFF; '
     'or straight, straight_7fff, in_place_clockwise, in_place_counter_clockwise'),
    ('Drive velocity=3', 1, 1, 'Drive lacks radius'),
    ('Drive velocity=3,4 radius=3', 1, 16,
     'Drive: velocity needs one value; allowed: -500 to 500 mm/s'),
    ('Wait Time time=', 1, 16, 'Wait Time: time needs one value; allowed: 0 to 255 (1/10 s)'),
    ('Drive speed=3', 1, 7, 'Drive has no field speed; allowed: velocity, radius'),
    ('Drive velocity=1\tVelocity=2', 1, 18, 'Drive: velocity is given twice'),
    ('Demo demo=-cover', 1, 11, 'Demo: demo = -cover; allowed: -1 to 9; or abort, cover, '),
    ('Wait Event event=not_me', 1, 18, 'Wait Event: event = not_me; allowed: '),
    ('Wait Event event=0', 1, 18,
     'Wait Event: event = 0; allowed: -22 to 22 (negative for the inverse), but not 0'),
    ('LEDs bits=play+red color=0 intensity=0', 1, 11,
     'LEDs: bits = play+red; allowed: a sum of 2 PLAY, 8 ADVANCE'),
    ('Stream packets=7,99', 1, 18,
     'Stream: packets[1] = 99; allowed: 0 to 42 or a name such as bumps_and_wheel_drops'),
    ('Stream packets=unused', 1, 16, 'Stream: packets[0] = unused; allowed: 0 to 42 or a name'),
    ('Song number=0 notes=C4:1,H4:1', 1, 26,
     "Song: notes: 'H4' is not a note; allowed: names such as C4, C#4 or Db4"),
    (f'Song number=0 notes={"9" * 5000}:1', 1, 21, f"Song: notes: '{'9' * 5000}' is not a note; "),
    ('Song number=0 notes=C4', 1, 21, 'Song: notes = C4; allowed: note:duration'),
    ('Song number=0 notes=C4:999', 1, 24, 'Song: notes, duration = 999; allowed: 0 to 255 ('),
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


# Tunes as people write them.


@pytest.mark.parametrize(('text', 'notes'), [
    ('C4:1/4', [(60, 16)]),
    ('c4:0.25, Db4:.5  rest:1/8\n60:2', [(60, 16), (61, 32), (REST, 8), (60, 128)]),
    ('31:1/64 127:255/64', [(31, 1), (127, 255)]),
    ('x:d=4,o=5,b=60:c,8d,2e4,f#.,p,8g.6,a6.,16h,32B', [
        (72, 64), (74, 32), (64, 128), (78, 96), (REST, 64), (91, 48), (93, 96), (83, 16),
        (83, 8)]),
    (' Two words :O=5, b=120 : 1c , 4e# ', [(72, 128), (77, 32)]),
    ('::4a4', [(69, 61)]),  # 60 / 63 s
    # What people have that differs.
    ('o=5,b=60:8c', [(72, 32)]), ('Star Wars: Main:d=8,b=60,o=5:c', [(72, 32)]),
    ('x:o=5,d=8,b=60,s=N,l=15:c', [(72, 32)]),
    ('x:b=60,o=5:8c.6,8c6.,8.c6', 3 * [(84, 48)]),
    ('x:b=60,o=5:b_,bb,h_4,d_,E_5,gb,a#', [
        (82, 64), (82, 64), (70, 64), (73, 64), (75, 64), (78, 64), (82, 64)]),
    ('x:b=60,o=4:64c,64p,12e,12e,12e', [(60, 4), (REST, 4), (64, 21), (64, 22), (64, 21)]),
    ('x:b=60,o=4: 8 c # , 1 6 P ;8d,\n', [(61, 32), (REST, 16), (62, 32)]),
    ('x:b=60,o=4:c,b=120,d=8,o=5,c,', [(60, 64), (72, 16)]),
    # What lasts longer than a note of the robot is a note again, or a rest of several.
    ('C4:4', [(60, 128)] * 2), ('rest:10 C4:1', [(REST, 213), (REST, 214), (REST, 213), (60, 64)]),
    ('x:b=25,o=4:1c.,1p', [(60, 230), (60, 231), (60, 230), (60, 231), (REST, 204), (REST, 205),
                           (REST, 205)]),
])
def test_a_tune_is_read(text, notes):
    assert list(parse_tune(text)) == notes


@given(st.lists(st.tuples(
    st.sampled_from([REST, *SOUNDING]), st.fractions(Fraction(1, 64), 3, max_denominator=999)),
    min_size=1))
def test_a_tune_keeps_its_speed(notes):
    text = ' '.join(f'{"rest" if number == REST else note_name(number)}:{length}'
                    for number, length in notes)
    played = parse_tune(text)
    assert [note.number for note in played] == [number for number, _ in notes]
    for count in range(1, len(notes) + 1):
        wanted = 64 * sum(length for _, length in notes[:count])
        assert abs(sum(note.duration for note in played[:count]) - wanted) <= Fraction(1, 2)


@pytest.mark.parametrize(('text', 'says'), [
    ('', 'a tune needs a note, such as C4:1/4'),
    ('x::', 'a tune needs a note'),
    ('C4', "'C4': a note has a length in seconds, such as C4:1/4, C4:0.25"),
    ('C4:1/0', 'such as C4:1/4'), ('C4:-1', 'such as C4:1/4'), ('C4:1e3', 'such as C4:1/4'),
    ('C4:1 E4:', "'E4:': a note has"), (f'C4:{"9" * 500}', 'such as C4:1/4'),
    ('C4:61', "'C4:61' lasts 61 s; allowed: 1/64 to 60 s"),
    ('C4:1/100', "'C4:1/100' lasts 0.01 s; allowed: 1/64"),
    ('X4:1', "'X4' is not a note; allowed: names such as C4"),
    ('F1:1', 'F1 makes no sound; allowed: 31 (G1) to 127 (G9)'),
    ('30:1', "note 30 makes no sound; allowed: 31 to 127, names such as C4, and 'rest'"),
    ('x:d=65:c', "'c' is a note of 1/65; allowed: 1 to 64"),
    ('x:t=4:c', "'t=4' is no default of a ring tone; allowed: d=4, o=6, b=63"),
    ('x:b=60:c,x=3', "'x=3' is no default"), ('x:b=60:c..', "'c..' is no note"),
    ('x:b=60:c,i', "'i' is no note of a ring tone; allowed: 8c, 4f#5, 16a. or 2p"),
    (f'{"9" * 5000}:1', 'is not a note; allowed: names such as C4'),
    (f'x:b={"9" * 5000}:c', 'is no default of a ring tone; allowed: d=4, o=6, b=63'),
    (f'x:b=60:{"9" * 5000}c', 'is no note of a ring tone; allowed: 8c'),
    ('x:b=3:1c', "'1c' lasts 80 s"), ('x:b=900:32c', "'32c' lasts 0.00833333 s; allowed: 1/64"),
], ids=str)
def test_a_wrong_tune_is_refused_and_what_is_allowed_said(text, says):
    with pytest.raises(ValueError) as refused:
        parse_tune(text)
    assert says in str(refused.value)


@given(st.text() | st.text('cdeabgh#_.:=,;opsl0123456789/ ', max_size=60))
def test_a_text_is_a_tune_or_refused(text):
    try:
        assert all(1 <= note.duration <= 255 for note in parse_tune(text))
    except ValueError as error:
        assert str(error)


def test_a_note_is_named_as_it_sounds():
    assert [note_text(number) for number in (60, REST, 30)] == ['C4', 'rest', '30']


# Waits that never end, and how long scripts take, from the script's own motion.


SEPARATION = FIRMWARE_SEPARATION * MM_PER_M


@pytest.mark.parametrize(('text', 'place', 'why'), [
    ('Drive velocity=0 radius=straight; Wait Distance distance=1000', 2, 'the wheels stand'),
    ('Wait Angle angle=90', 1, 'the wheels stand'),
    ('Drive velocity=200 radius=in_place_clockwise; Wait Angle angle=90', 2, 'turns clockwise'),
    ('Drive velocity=200 radius=in_place_clockwise; Wait Distance distance=9', 2, 'in place'),
    ('Drive velocity=200 radius=straight; Wait Angle angle=90', 2, 'does not turn'),
    ('Drive Direct right=1 left=0; Wait Angle angle=-90', 2, 'turns counter-clockwise'),
    ('Drive Direct right=1 left=0; Wait Distance distance=-9', 2, 'drives forwards'),
    ('Drive Direct right=-1 left=0; Wait Distance distance=9', 2, 'drives backwards'),
    ('Drive velocity=200 radius=straight; Wait Time time=5; Start; Wait Distance distance=9',
     4, 'the wheels stand'),
    ('Cover; Demo demo=abort; Wait Distance distance=9', 3, 'the wheels stand'),
])
def test_a_wait_that_the_motion_does_not_lead_to_never_ends(text, place, why):
    found = endless_wait(parse_script(text), oi.Mode.SAFE, SEPARATION)
    assert found is not None
    assert found.place == place
    assert why in found.why
    assert duration(parse_script(text), oi.Mode.SAFE, SEPARATION) is None


@pytest.mark.parametrize(('text', 'seconds'), [
    ('Drive velocity=300 radius=straight; Wait Distance distance=400; '
     'Drive velocity=0 radius=straight', 4 / 3),
    ('Drive velocity=-200 radius=straight; Wait Distance distance=-100', 0.5),
    ('Drive velocity=100 radius=in_place_clockwise; Wait Angle angle=-90', 2.026),
    ('Wait Time time=20; Wait Distance distance=0', 2.0),
    ('LEDs bits=play color=0 intensity=0', 0.0),
])
def test_how_long_a_script_takes(text, seconds):
    script = parse_script(text)
    assert endless_wait(script, oi.Mode.SAFE, SEPARATION) is None
    assert duration(script, oi.Mode.SAFE, SEPARATION) == pytest.approx(seconds, abs=0.001)


@pytest.mark.parametrize('text', [
    'Wait Event event=bump', 'Wait Time time=1; Play Script', 'Demo demo=cover', *(
        f'{demo}; Wait {wait}' for demo in ('Cover', 'Cover and Dock', 'Spot', 'Demo demo=mouse')
        for wait in ('Distance distance=500', 'Angle angle=-40', 'Time time=50'))])
def test_nobody_knows_how_long_an_event_a_demo_or_a_loop_takes(text):
    script = parse_script(text)
    assert endless_wait(script, oi.Mode.SAFE, SEPARATION) is None
    assert duration(script, oi.Mode.SAFE, SEPARATION) is None


def test_in_passive_a_drive_is_ignored_until_the_script_enters_another_mode():
    drive = 'Drive velocity=200 radius=straight; Wait Distance distance=100'
    found = endless_wait(parse_script(drive), oi.Mode.PASSIVE, SEPARATION)
    assert found is not None and found.why == 'the wheels stand'
    assert endless_wait(parse_script(f'Safe; {drive}'), oi.Mode.PASSIVE, SEPARATION) is None
