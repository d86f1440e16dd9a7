"""The rows of a text under one separator: how many fields, which are numbers, where they begin."""

from __future__ import annotations

import csv
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import islice, pairwise

from footcal_cli.sniff.names import name_guess
from footcal_cli.sniff.tokens import (
    NOTHING,
    Decimal,
    is_moment,
    is_number,
    number_signs,
    with_unit,
    worth,
)
from footcal_cli.tables.drawn import TEX, is_rule, undrawn
from footcal_cli.tables.reading import BLANKS

_SPARSE = 0.1
"""Share of rows with more empty cells than numbers from which a table is sparse."""


def fields_of(line: str, separator: str) -> list[str]:
    """Fields of a line, stripped."""
    line = undrawn(line, separator)
    if separator == BLANKS:
        return line.split()
    line = line.strip("\r\n")
    if line and '"' not in line and "\r" not in line and "\n" not in line:  # most: much faster
        return list(map(str.strip, line.split(separator)))
    return [f.strip() for f in next(csv.reader([line], delimiter=separator), [])]


def filled_fields(line: str, separator: str) -> list[str]:
    """Fields of a line up to the last that is not empty."""
    return fields_of(undrawn(line, separator).rstrip(separator), separator)


Ranges = tuple[float, float, int, int]
"""Least and largest number of a column, fewest and most decimals."""
_A_VALUE = 0.5
"""What a number or a moment is worth at least; a word is worth less."""
_WORDED = 3
"""Columns of numbers from which a row with a word in one of them still is a row."""
_LINES_OF_A_SHEET = 60
_LOOKED_AT = 2000


def on_its_side(lines: Sequence[str]) -> str:
    """The separator of a sheet whose lines begin with their names; empty for all others.

    All other fields are numbers, the names differ, and one of them is that of a load.
    """
    written = [line for line in lines if line.strip()]
    if not 2 <= len(written) <= _LINES_OF_A_SHEET:
        return ""
    for separator in (";", "\t", ","):
        table = [fields_of(line, separator) for line in written]
        if len(set(map(len, table))) != 1 or len(table[0]) < 3:
            continue
        signs = number_signs([field for row in table for field in row[1:]], separator)
        names = [row[0] for row in table]
        numbers = all(is_number(field, *signs) for row in table for field in row[1:])
        worded = not any(is_number(name, *signs) or is_moment(name) for name in names)
        loads = [name for name in names if name_guess(name).quantity == "load"]
        if numbers and worded and len(loads) == 1 and len(set(names)) == len(names):
            return separator
    return ""


def _below(lines: Sequence[str]) -> list[str]:
    """The last lines of a short text, without its first, which may name the columns."""
    return list(lines[-min(3, max(1, len(lines) - 1)) :])


def _filled(lines: Sequence[str], separator: str, width: int) -> bool:
    """Whether a line has a value in its last field of so many: a sensor that was slower or shorter.

    Words are no values: a header may announce remarks that nobody wrote.
    """
    last = [row[-1] for row in (filled_fields(x, separator) for x in lines) if len(row) == width]
    return any(is_number(field, sign) for field in last for sign in ".,")


def _all_named(line: str, separator: str, width: int) -> bool:
    """Whether a first line has a name for each of so many fields: of streams that gave nothing."""
    names = filled_fields(line, separator)
    one = all(names) and len({*names}) == len(names)
    return len(names) == width and one and not any(is_number(n, s) for n in names for s in ".,")


def _counts(fields: Sequence[str]) -> bool:
    """Whether fields number the rows one by one."""
    if len(fields) < 2 or not all(field.isdecimal() for field in fields):
        return False
    return all(int(b) - int(a) == 1 for a, b in pairwise(fields))


@dataclass(eq=False)
class Body:
    """The rows of a text under one separator; remembers which lines it was asked for.

    `share` of the lines have `width` fields; `numbers` of these hold numbers, in `numeric` columns;
    `sparse` where many rows lack half of them, as topics do that take turns; `whole` where no field
    looks like two that ran together; `counted` where the first field numbers the rows; `spoken`
    where all numbers have their unit behind them.
    """

    separator: str
    decimal: Decimal
    thousands: str
    width: int
    share: float
    numbers: float
    score: float
    numeric: tuple[int, ...]
    sparse: bool
    whole: bool
    counted: bool
    spoken: bool
    indented: bool
    _known: dict[tuple[str, bool], bool] = field(default_factory=dict, init=False, repr=False)

    @classmethod
    def of(cls, written: list[str], separator: str) -> Body:
        """The rows under a separator, judged by the written lines behind the first third."""
        tail = written[len(written) // 3 :][:400] if len(written) > 6 else _below(written)
        tail = [line for line in tail if not line.lstrip().startswith(("#", "%", "//"))] or tail
        split = [filled_fields(line, separator) for line in tail]
        width, alike = Counter(map(len, split)).most_common(1)[0]
        open_ended = [fields_of(line, separator) for line in tail]
        longer, more = Counter(map(len, open_ended)).most_common(1)[0]
        wide = (
            more == alike
            and longer > width
            and (
                _filled(written[:_LOOKED_AT], separator, longer)
                or _all_named(written[0], separator, longer)
            )
        )
        if more > alike or wide:
            split, width = open_ended, longer  # cells at the end of rows may be empty
        rows = [row for row in split if len(row) == width]
        signs = number_signs([f for row in rows for f in row], separator)
        numbers = [[is_number(field, *signs) for field in row] for row in rows]
        worths = [
            [1.0 if number else worth(field, *signs) for field, number in zip(*own, strict=True)]
            for own in zip(rows, numbers, strict=True)
        ]
        if separator == BLANKS:  # words with a blank between them are no more fields for it
            worths = [[one if one >= _A_VALUE else 0.0 for one in own] for own in worths]
        share = len(rows) / len(split)
        numeric = tuple(
            i for i in range(width)
            if sum(own[i] for own in numbers) + sum(not row[i] for row in rows) > 0.8 * len(rows)
            and any(own[i] for own in numbers)
        )  # fmt: skip
        spoken = not numeric
        if spoken:
            numeric = tuple(
                i for i in range(width)
                if sum(with_unit(row[i]) is not None for row in rows) > 0.8 * len(rows)
            )  # fmt: skip
        both = list(zip(rows, numbers, strict=True))
        moments = sum(
            sum(not own[i] and is_moment(row[i]) for row, own in both) > 0.8 * len(rows)
            for i in range(width)
        )
        score = share * sum(map(sum, worths)) / len(rows)
        halves = [sum(not row[i] for i in numeric) * 2 > len(numeric) for row in rows]
        sparse = sum(halves) > _SPARSE * len(rows)
        whole = min(min(own) for own in worths) >= 0.0
        return cls(
            separator, *signs, width, share, len(numeric) + moments, score, numeric, sparse, whole,
            _counts([row[0].strip('"').rstrip(".") for row in rows]), spoken,
            width > 1 and not any(row[0] for row in rows),
        )  # fmt: skip

    def begins_at(self, lines: list[str]) -> int:
        """Where the rows begin: a line above them may hold a number or two beside its words."""
        whole = (i for i, line in enumerate(lines) if self.is_row(line, whole=True))
        some = (i for i, line in enumerate(lines) if self.is_row(line))
        first = next(whole, next(some, 0))
        if lines and self._says_lengths(lines, first):
            return first + 1
        return self._with_worded_rows(lines, first)

    def _with_worded_rows(self, lines: list[str], first: int) -> int:
        """Where the rows begin if a word stands for a number in the first (``1,Tare,0.301``).

        Names and units are no rows: their numbers, if any, are not as those of the rows below.
        """
        if self.spoken or len(self.numeric) < _WORDED:
            return first
        if first < 2 or not self.is_row(lines[first - 1]):  # most logs: the rest is long
            return first
        whole = (x for x in islice(lines, first, None) if self.is_row(x, whole=True))
        below = [fields_of(x, self.separator) for x in islice(whole, _LOOKED_AT)]
        seen = {i: self._ranges([row[i] for row in below]) for i in self.numeric}
        while first > 1 and self._as_below(lines[first - 1], seen):
            first -= 1
        return first

    def _ranges(self, column: list[str]) -> Ranges | None:
        """Least and largest number of a column, and how many decimals these are written with."""
        good = [text for text in column if is_number(text, self.decimal, self.thousands)]
        if not good:
            return None
        values = [self._value(text) for text in good]
        places = [self._places(text) for text in good]
        return min(values), max(values), min(places), max(places)

    def _value(self, text: str) -> float:
        plain = text.replace(self.thousands, "").replace(self.decimal, ".")
        return float(int(plain, 16)) if plain[:2].lower() == "0x" else float(plain)

    def _places(self, text: str) -> int:
        return len(text.lower().partition("e")[0].partition(self.decimal)[2])

    def _as_below(self, line: str, seen: Mapping[int, Ranges | None]) -> bool:
        """Whether most columns of numbers go on in a line, by size and decimals, and not all alike.

        A robot in the air, or an empty plate, may be far from the rest in some columns.
        """
        if not self.is_row(line):
            return False
        fields = fields_of(line, self.separator)
        fitting = []
        for i in self.numeric:
            own = seen[i]
            if own is None or not is_number(fields[i], self.decimal, self.thousands):
                continue
            low, high, fewest, most = own
            value, reach = self._value(fields[i]), high - low
            if not fewest <= self._places(fields[i]) <= most:
                return False
            if low - reach <= value <= high + reach:
                fitting.append(value)
        return 2 * len(fitting) > len(self.numeric) and len({*fitting}) > 1

    def _says_lengths(self, lines: list[str], first: int) -> bool:
        """Whether the first row is none, but says in every column how many rows are below it."""
        said = set(filled_fields(lines[first], self.separator))
        if self.width < 2 or len(said) != 1 or not (number := said.pop()).isdecimal():
            return False
        return int(number) == sum(map(self.is_row, lines[first + 1 :])) > 1

    def is_row(self, line: str, *, whole: bool = False) -> bool:
        """Whether a line is a row; `whole`: no word stands where numbers should."""
        if (line, whole) not in self._known:  # several rules ask it of every line of a log
            self._known[line, whole] = self._is_row(line, whole=whole)
        return self._known[line, whole]

    def _is_row(self, line: str, *, whole: bool) -> bool:
        fields = filled_fields(line, self.separator)
        if len(fields) < self.width:
            fields = fields_of(line, self.separator)[: self.width]
        if len(fields) != self.width or (self.indented and fields[0]):
            return False
        if self.counted and not fields[0]:
            return False
        if not self.numeric:
            return any(is_moment(field) for field in fields)
        good = [
            with_unit(fields[i]) is not None if self.spoken
            else is_number(fields[i], self.decimal, self.thousands) for i in self.numeric
        ]  # fmt: skip
        if whole:
            nothing = [fields[i].lower() in NOTHING for i in self.numeric]
            return any(good) and all(a or b for a, b in zip(good, nothing, strict=True))
        if self.sparse and any(good):
            return all(ok or not fields[i] for i, ok in zip(self.numeric, good, strict=True))
        return sum(good) >= max(1, (len(good) + 1) // 2)


def _separates(separator: str, line: str) -> bool:
    """Whether a line may have more than one field, or another one, under a separator."""
    return separator == BLANKS or separator in line or (separator == TEX and "\\\\" in line)


def best_body(lines: list[str], separators: Sequence[str]) -> Body:
    """The rows under the separator by which most fields are numbers.

    Bars that stand between whole fields separate them, though a blank within a date gives more.
    """
    written = [line for line in lines if line.strip() and not is_rule(line)]
    # what stands nowhere separates nothing: the first of these is like all others
    nowhere = [s for s in separators if not any(_separates(s, line) for line in written)]
    bodies = [Body.of(written, s) for s in separators if s not in nowhere[1:]]
    best = max(bodies, key=lambda body: body.score)
    barred = next((b for b in bodies if b.separator == "|" and b.width > 1 and b.numbers), None)
    between = best.separator == BLANKS and barred is not None and barred.whole
    return barred if between and barred is not None and barred.share >= best.share else best
