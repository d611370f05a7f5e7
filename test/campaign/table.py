"""What came of all tries, as a table."""

from dataclasses import dataclass, field
from statistics import median

from campaign.cases import Fault, Outcome

HEAD = ('fault', 'tried', 'recovered', 'median s', 'worst s', 'wrong values',
        'zero speed: median s', 'worst s')


@dataclass
class Row:
    """One fault, and what came of it each time."""

    fault: Fault
    outcomes: list[Outcome] = field(default_factory=list)
    patience: float = 1.0
    """How many times longer than promised things may take."""

    def fails(self, outcome: Outcome) -> str:
        """Say why a try has failed, or ''."""
        limits = ((self.fault.recovery, outcome.recovery, 'recovery'),
                  (self.fault.zero, outcome.zero, 'zero speed'))
        late = [f'{what} after {took:.3f} s, not {limit:g} s' for limit, took, what in limits
                if limit is not None and took is not None and took > limit * self.patience]
        return '; '.join(filter(None, (outcome.trouble, *late, *outcome.wrong[:1])))

    @property
    def failures(self) -> list[str]:
        """Why tries have failed."""
        return [why for outcome in self.outcomes if (why := self.fails(outcome))]

    def cells(self) -> tuple[str, ...]:
        """Return the row of the table."""
        recovered = sum(not outcome.trouble for outcome in self.outcomes)
        return (
            self.fault.name, str(len(self.outcomes)), str(recovered),
            *_times([outcome.recovery for outcome in self.outcomes]),
            str(sum(len(outcome.wrong) for outcome in self.outcomes)),
            *_times([outcome.zero for outcome in self.outcomes]))


def _times(values: list[float | None]) -> tuple[str, str]:
    known = [value for value in values if value is not None]
    return (f'{median(known):.3f}', f'{max(known):.3f}') if known else ('-', '-')


def markdown(rows: list[Row]) -> str:
    """Return the table."""
    lines = [HEAD, ('---',) * len(HEAD), *(row.cells() for row in rows)]
    return ''.join(f'| {" | ".join(line)} |\n' for line in lines)


def as_json(rows: list[Row]) -> list[dict[str, object]]:
    """Return every try, to be written as JSON."""
    return [{'fault': row.fault.name, **vars(outcome), 'failure': row.fails(outcome)}
            for row in rows for outcome in row.outcomes]
