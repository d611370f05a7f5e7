# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""The results of all tries, as a table and as JSON."""

from dataclasses import dataclass, field
from statistics import median

from campaign.fault import Fault, Result
from support.tables import markdown_table

HEAD = ('fault', 'tried', 'recovered', 'median s', 'worst s', 'wrong values',
        'zero speed: median s', 'worst s')


@dataclass
class Row:
    """One fault and the results of its tries."""

    fault: Fault
    results: list[Result] = field(default_factory=list)
    slack: float = 1.0
    """Factor for the limits: more than 1 on a busy machine."""

    def failure(self, result: Result) -> str:
        """Return why a try has failed; empty if it has not."""
        limits = ((self.fault.recovery, result.recovery, 'recovery'),
                  (self.fault.zero, result.zero, 'zero speed'))
        late = [f'{what} after {took:.3f} s, not {limit:g} s' for limit, took, what in limits
                if limit is not None and took is not None and took > limit * self.slack]
        return '; '.join(filter(None, (result.trouble, *late, *result.wrong[:1])))

    @property
    def failures(self) -> list[str]:
        """Why tries have failed, for each that has."""
        return [why for result in self.results if (why := self.failure(result))]

    def cells(self) -> tuple[str, ...]:
        """Return the row of the table."""
        recovered = sum(not result.trouble for result in self.results)
        return (
            self.fault.name, str(len(self.results)), str(recovered),
            *_times([result.recovery for result in self.results]),
            str(sum(len(result.wrong) for result in self.results)),
            *_times([result.zero for result in self.results]))


def _times(values: list[float | None]) -> tuple[str, str]:
    known = [value for value in values if value is not None]
    return (f'{median(known):.3f}', f'{max(known):.3f}') if known else ('-', '-')


def markdown(rows: list[Row]) -> str:
    """Return the table of all faults."""
    return markdown_table(HEAD, [row.cells() for row in rows])


def as_json(rows: list[Row]) -> list[dict[str, object]]:
    """Return every try as a JSON object."""
    return [{'fault': row.fault.name, **vars(result), 'failure': row.failure(result)}
            for row in rows for result in row.results]
