# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""The last step of `create_check`: what a tape measure says becomes the scales of the odometry."""

from math import degrees

import pytest

from create_oi_ros.apps.check.questions import by_tape, in_lines, Person
from create_oi_ros.apps.check.runner import Notebook, Runner
from support.loop import Loop


class Line:
    """A robot in memory in place of that at a port."""

    def __init__(self) -> None:
        self.notebook = Notebook()
        self.loop = Loop(odometry=self.notebook)
        self.runner = Runner(self.loop.driver, self.notebook)
        self.loop.run(0.5)

    def make(self, move) -> bool:
        """Make a move."""
        self.runner.begin(move)
        while self.runner.busy:
            self.loop.turn()
            self.runner.poll(self.loop.now)
        return self.runner.disturbance is None


@pytest.fixture
def check(monkeypatch):
    """Return a function that does the step, with answers for each of its questions in turn."""
    def do(*answers):
        line, questions = Line(), []
        told = iter(answers)

        def answer(question):
            questions.append(question)
            if question.endswith('Enter: ') and 'Mark' in question or 'back' in question:
                return ''
            given = next(told)
            return str(given(line) if callable(given) else given)
        monkeypatch.setattr('builtins.input', answer)
        return by_tape(line, Person(absent=False)), line, questions
    return do


def test_what_the_tape_says_becomes_the_scales(check):
    start = []

    def came(line):
        return line.loop.body.truth().pose.x * 1.03

    def beyond(line):  # what it reports, and ten degrees more in each direction
        turned = line.notebook.turned - (start[0] if start else 0.0)
        start[:] = [line.notebook.turned]
        return abs(degrees(turned)) - 1080 + 10
    found, _, _ = check('y', came, beyond, beyond)
    assert found['linear_scale'] == pytest.approx(1.03, abs=0.01)
    assert found['angular_scale'] == pytest.approx(1 + 10 / 1080, abs=0.001)
    assert found['wheel_separation'] == pytest.approx(0.258 / found['angular_scale'])
    assert in_lines(found)[1].strip().startswith('linear_scale: 1.0')


def test_what_cannot_be_is_asked_again_and_an_empty_answer_leaves_it_out(check, capsys):
    found, line, _ = check('y', 'a metre', '97', '', '')
    assert found == {} and in_lines(found) == []
    printed = capsys.readouterr().out
    assert "'a metre' is no number" in printed
    assert 'allowed is up to 20%' in printed and 'right unit' in printed
    assert abs(line.loop.body.truth().pose.x) < 0.05, 'it drove back'


def test_without_a_tape_measure_nothing_moves(check):
    found, line, questions = check('n')
    assert found == {} and len(questions) == 1 and line.notebook.travelled == 0.0


def test_a_move_that_is_disturbed_is_not_measured(check, capsys):
    def lifted(line):
        line.loop.body.lift(True)
        return 'y'
    found, _, _ = check(lifted)
    assert found == {}
    assert 'Not measured: ' in capsys.readouterr().out
