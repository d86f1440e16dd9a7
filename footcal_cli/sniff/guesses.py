"""A guess at a log: what each column is taken for, how sure, and by what."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Literal

import numpy as np

from footcal_cli.core.parameters import FloatArray, IntArray
from footcal_cli.sniff.names import NameGuess, Quantity
from footcal_cli.sniff.text import TextGuess
from footcal_cli.tables.reading import Layout
from footcal_cli.tables.sources import stem_of
from footcal_cli.tables.units import TIMES

Sure = Literal["sure", "likely", "guess"]


@dataclass(frozen=True)
class ColumnGuess:
    """What a column is taken for.

    Parameters
    ----------
    column
        Its name in the file.
    name
        What its name says; the quantity may come from the numbers instead.
    unit
        Of its numbers, None where nothing says so.
    sure, why
        How sure, and by what.
    values
        Its numbers, shape (n,); None for texts.
    words
        Different texts of a text column, in order of appearance.
    codes
        Which of `words` stands in each row, shape (n,), −1 where none does.
    format, pattern, nanoseconds, plus, minus, add, wraps_at, summed, held, missing, names,
    high_word, over, followed_by
        How it is read, as in `footcal_cli.tables.reading.ForeignColumn`; `values` are read so:
        they hold sums, ratios and whole registers, and a counter goes on counting.
    stamps
        Of dates: seconds since the first, shape (n,).
    """

    column: str
    name: NameGuess
    unit: str | None
    sure: Sure
    why: str
    values: FloatArray | None = None
    words: tuple[str, ...] = ()
    format: str | None = None
    pattern: str | None = None
    codes: IntArray | None = None
    nanoseconds: str = ""
    plus: Mapping[str, str] = field(default_factory=dict)
    minus: str = ""
    add: float = 0.0
    wraps_at: float | None = None
    summed: bool = False
    held: bool = False
    missing: tuple[str, ...] = ()
    names: Mapping[str, str] = field(default_factory=dict)
    stamps: FloatArray | None = None
    high_word: str = ""
    over: str = ""
    followed_by: str = ""

    @property
    def quantity(self) -> Quantity:
        """What is measured."""
        return self.name.quantity

    @property
    def counts(self) -> bool:
        """Whether its numbers are those of a converter: whole ones."""
        if self.values is None:
            return False
        good = self.values[np.isfinite(self.values)]
        return bool(good.size and np.all(good == np.round(good)) and np.ptp(good) > 3)

    def as_quantity(self, quantity: Quantity, sure: Sure, why: str) -> ColumnGuess:
        """The same column taken for something else."""
        name = replace(self.name, quantity=quantity)
        return replace(self, name=name, sure=sure, why=why)


def numbers_of(column: ColumnGuess) -> FloatArray:
    """Numbers of a column that was chosen because it has some, shape (n,)."""
    assert column.values is not None, f"'{column.column}' holds texts"
    return column.values


def seconds_of(column: ColumnGuess) -> FloatArray | None:
    """A column of time in seconds, shape (n,); None where it holds neither numbers nor dates."""
    if column.values is None:
        return column.stamps
    return column.values * TIMES.get(column.unit or "s", 1.0)


def codes_of(column: ColumnGuess) -> IntArray:
    """Which of its words stands in each row of a column of texts, shape (n,)."""
    assert column.codes is not None, f"'{column.column}' holds numbers"
    return column.codes


@dataclass(frozen=True)
class FileGuess:
    """One log: how it is laid out and what its columns are taken for.

    Parameters
    ----------
    joined
        Other files whose columns stand among its own, at its stamps: ``pose.x`` behind their name.
    """

    path: Path
    text: TextGuess
    columns: tuple[ColumnGuess, ...]
    rows: int
    rate_hz: float | None = None
    rows_of: str = ""
    joined: tuple[FileGuess, ...] = ()

    @property
    def layout(self) -> Layout:
        """How its text is laid out."""
        return self.text.layout

    def of(self, *quantities: str) -> list[ColumnGuess]:
        """Columns taken for any of these."""
        return [column for column in self.columns if column.quantity in quantities]


def looked_at_joined(
    file: FileGuess, look: Callable[[FileGuess], FileGuess | None]
) -> FileGuess | None:
    """What `look` makes of a log whose columns are all called after their own files."""
    if not file.joined:
        return look(file)
    before = f"{stem_of(file.path)}."
    theirs = tuple(f"{n}." for other in file.joined for n in (stem_of(other.path), other.path.name))
    plain = {c.column if c.column.startswith(theirs) else before + c.column: c.column
             for c in file.columns}  # fmt: skip
    names = {own: name for name, own in plain.items()}
    called = tuple(replace(c, column=names[c.column]) for c in file.columns)
    found = look(replace(file, columns=called))
    if found is None:
        return None
    return replace(found, columns=tuple(replace(c, column=plain[c.column]) for c in found.columns))


def as_one(group: Sequence[FileGuess], more: Sequence[ColumnGuess]) -> FileGuess:
    """Several logs of the same columns below each other, with columns that say of which each is."""
    columns = []
    for at, first in enumerate(group[0].columns):
        parts = [file.columns[at].values for file in group]
        texts = [file.columns[at] for file in group]
        if all(text.codes is not None for text in texts):
            columns.append(_texts_below(texts))
        if any(part is None for part in parts):
            continue
        whole: FloatArray = np.concatenate([part for part in parts if part is not None])
        columns.append(replace(first, values=whole))
    rows = sum(file.rows for file in group)
    return replace(group[0], columns=(*more, *columns), rows=rows)


def _texts_below(texts: Sequence[ColumnGuess]) -> ColumnGuess:
    """Columns of texts below each other, with one list of words."""
    words = tuple(dict.fromkeys(word for text in texts for word in text.words))
    codes = []
    for text in texts:
        own = np.array([*(words.index(word) for word in text.words), -1])
        codes.append(own[codes_of(text)])
    return replace(texts[0], words=words, codes=np.concatenate(codes))
