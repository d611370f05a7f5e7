# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Tunes as people write them, and what is wrong with others."""

from fractions import Fraction

from hypothesis import given
from hypothesis import strategies as st
import pytest

from create_oi_ros.oi.commands import REST, SOUNDING
from create_oi_ros.oi.tools.tunes import note_name, note_text, parse_tune


@pytest.mark.parametrize(('text', 'notes'), [
    ('C4:1/4', [(60, 16)]),
    ('c4:0.25, Db4:.5  rest:1/8\n60:2', [(60, 16), (61, 32), (REST, 8), (60, 128)]),
    ('31:1/64 127:255/64', [(31, 1), (127, 255)]),
    ('x:d=4,o=5,b=60:c,8d,2e4,f#.,p,8g.6,a6.,16h,32B', [
        (72, 64), (74, 32), (64, 128), (78, 96), (REST, 64), (91, 48), (93, 96), (83, 16),
        (83, 8)]),
    (' Two words :O=5, b=120 : 1c , 4e# ', [(72, 128), (77, 32)]),
    ('::4a4', [(69, 61)]),  # 60 / 63 s
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
    ('C4:4', "'C4:4' lasts 4 s; allowed: 1/64 to 255/64 s (3.98)"),
    ('C4:1/100', "'C4:1/100' lasts 0.01 s; allowed: 1/64"),
    ('X4:1', "'X4' is not a note; allowed: names such as C4"),
    ('F1:1', 'F1 makes no sound; allowed: 31 (G1) to 127 (G9)'),
    ('30:1', "note 30 makes no sound; allowed: 31 to 127, names such as C4, and 'rest'"),
    ('128:1', 'note 128 makes no sound'),
    ('x:d=3:c', "'c' is a note of 1/3; allowed: 1, 2, 4, 8, 16, 32"),
    ('x:s=4:c', "'s=4' is no default of a ring tone; allowed: d=4, o=6, b=63"),
    ('x:b=0:c', "'b=0' is no default"), ('x:b=fast:c', "'b=fast' is no default"),
    ('x:b=60:c,i', "'i' is no note of a ring tone; allowed: 8c, 4f#5, 16a. or 2p"),
    ('x:b=60:64c', 'a note of 1/64'), ('x:b=60:c0', 'c0 makes no sound'),
    ('x:b=60:1c', "'1c' lasts 4 s"), ('x:b=900:32c', 'lasts 0.00833333 s'),
], ids=str)
def test_a_wrong_tune_is_refused_and_what_is_allowed_said(text, says):
    with pytest.raises(ValueError) as refused:
        parse_tune(text)
    assert says in str(refused.value)


@given(st.text() | st.text('cdeabgh#.:=,op0123456789/ ', max_size=60))
def test_a_text_is_a_tune_or_refused(text):
    try:
        assert all(1 <= note.duration <= 255 for note in parse_tune(text))
    except ValueError as error:
        assert str(error)


def test_a_note_is_named_as_it_sounds():
    assert [note_text(number) for number in (60, REST, 30)] == ['C4', 'rest', '30']
