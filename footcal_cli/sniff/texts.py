"""Columns of texts: dates, labels, numbers with words or units beside them, bare hexadecimal."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np

from footcal_cli.core.parameters import FloatArray, IntArray
from footcal_cli.sniff.guesses import ColumnGuess
from footcal_cli.sniff.names import NameGuess, Quantity
from footcal_cli.sniff.said_weights import said_weight, says_nothing, sums_of
from footcal_cli.sniff.sides import sides_in
from footcal_cli.sniff.silent import MEASURED, words_for_nothing
from footcal_cli.sniff.tokens import (
    DAY,
    FRACTION,
    HEXADECIMAL,
    IN_WORDS,
    PLUS_MINUS,
    SIDES,
    date_format,
    with_unit,
)
from footcal_cli.sniff.units import MASSES, NO_READING, VOLTAGES, WEIGHTS, known_unit
from footcal_cli.sniff.vocabulary import DIRECTIONS, LETTERS
from footcal_cli.tables.rawcolumn import RawColumn
from footcal_cli.tables.units import TIMES
from footcal_cli.tables.values import bare_hexadecimal, since_the_first

_MOST_WORDS = 500
"""Different texts of a column in whose rows they may be asked for."""
FEW = 25
"""A load takes no more than so many values, and so many sensors have a name."""
_RARE = 0.3
"""Share of rows in which a column of weights may say something else: a shunt, a subtotal."""
_ROWS_A_DAY = 3
"""So many rows at least have the date of one day, where a column says on which one."""
_LEAST_OF_ONE = 3
"""Rows that a bench has of each cell in one go."""
_EVENTS = 0.5
"""Share of empty cells from which a column holds events."""
MEAN_IN_A_CELL = r"^([-+]?[\d.,]+)"
_UNIT_COLUMN = re.compile(r"(?i)(.*?)[\W_]*(?:unit|units|einheit)\W*")
_VALUE_COLUMN = re.compile(r"(?i)[\W_]*(?:value|wert|val)?\W*$")


def units_beside(columns: list[ColumnGuess]) -> list[ColumnGuess]:
    """A unit that stands as a text beside its number: ``load.value`` and ``load.unit``."""
    units = {}
    for column in columns:
        found = _UNIT_COLUMN.fullmatch(column.column)
        if found and len(column.words) == 1 and (unit := known_unit(column.words[0])):
            units[found[1]] = unit
    for column, after in pairwise(columns):
        # numbers without names, each with its unit in the next field: `1.02,lbs`
        if len(after.words) == 1 and after.column.startswith("column_"):
            unit = known_unit(after.words[0])
            units |= {column.column: unit} if unit else {}
    made = []
    for column in columns:
        stem = _VALUE_COLUMN.sub("", column.column)
        unit = units.get(column.column, units.get(stem))
        unit = unit if column.values is not None and column.unit is None else None
        made.append(column if unit is None else replace(column, unit=unit))
    return made


def _in_rows(numbers: Sequence[float] | FloatArray, raw: RawColumn) -> FloatArray:
    """Numbers of the cells that are not empty at their rows, NaN in the others, shape (n,)."""
    values = np.full(len(raw.values), np.nan)
    values[~raw.empty] = numbers
    return values


_TURNS = 3
"""So often numbers come again in one order by no chance."""
_DECIMAL = re.compile(r"[-+]?\d+(?:[.,]\d+)?")
_ZERO = re.compile(r"[-+]?0+(?:[.,]0*)?")
_PLAIN = re.compile(r"[-+]?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?")


def text_column(column: str, name: NameGuess, unit: str | None, raw: RawColumn) -> ColumnGuess:
    """Dates, numbers with a unit beside them, or labels."""
    words = [str(v).strip() for v, e in zip(raw.values, raw.empty, strict=True) if not e]
    some = words[:: max(1, len(words) // 40)]
    iso = bool(some) and all(re.match(r"\d{4}-\d\d-\d\d[T ]\d\d:\d\d", word) for word in some)
    if iso and len(words) > 1 and len({*words}) == 1:
        name = replace(name, quantity="other")
        return ColumnGuess(column, name, None, "likely", "the same stamp in every row")
    if iso:
        name, since = replace(name, quantity="time"), since_the_first(raw, "ISO8601")
        return ColumnGuess(column, name, None, "sure", "ISO 8601 dates", stamps=since)
    different = tuple(dict.fromkeys(words))
    days = bool(some) and all(DAY.fullmatch(word) for word in some)
    if days and 1 < len(different) <= FEW and len(words) >= _ROWS_A_DAY * len(different):
        codes = np.full(len(raw.values), -1)
        codes[~raw.empty] = [different.index(word) for word in words]
        name = NameGuess("session")
        return ColumnGuess(column, name, None, "likely", "days", words=different, codes=codes)
    form = date_format(some) if some else None
    if form is not None:
        name = replace(name, quantity="time")
        since = since_the_first(raw, form)
        return ColumnGuess(column, name, None, "sure", f"dates {form}", format=form, stamps=since)
    marked = all(HEXADECIMAL.fullmatch(word) for word in words)
    if words and (marked or (bare_hexadecimal(words) and not _serials(different))):
        values = _in_rows([float(int(word, 16)) for word in words], raw)
        name = replace(name, quantity="reading" if len({*words}) > 1 else "other")
        return ColumnGuess(column, name, None, "likely", "hexadecimal numbers", values)
    means = [found[1] for word in words if (found := PLUS_MINUS.fullmatch(word))]
    if words and len(means) == len(words):
        values = _in_rows([float(mean.replace(",", ".")) for mean in means], raw)
        name = replace(name, quantity="reading" if name.quantity == "label" else name.quantity)
        why = "means with their scatter, which is left out"
        return ColumnGuess(column, name, unit, "likely", why, values, pattern=MEAN_IN_A_CELL)
    parts = [found for word in words if (found := FRACTION.fullmatch(word))]
    full = {int(found[2]) for found in parts}
    if words and len(parts) == len(words) and len(full) == 1 and _full_scale(full.pop()):
        values = _in_rows([float(found[1]) for found in parts], raw)
        why = f"numbers of {parts[0][2]} at full scale"
        name = replace(name, quantity="reading")
        return ColumnGuess(column, name, None, "likely", why, values, pattern=r"^([-+]?\d+)\s*/")
    # where no load is written as 0, a word among loads says none of them: one is being changed
    empty_said = name.quantity == "load" and any(_ZERO.fullmatch(word) for word in words)
    between = name.quantity in (*MEASURED, "other") or empty_said
    nothing = words_for_nothing(words, any_word=between)
    if nothing:
        said = [str(v).strip() for v in raw.values.tolist()]
        numbers = np.array([
            np.nan if empty or word in nothing else float(word.replace(",", "."))
            for word, empty in zip(said, raw.empty, strict=True)
        ])  # fmt: skip
        why = f"numbers; {', '.join(nothing)} is taken for no reading"
        return ColumnGuess(column, name, unit, "likely", why, numbers, missing=nothing)
    if words and all(_PLAIN.fullmatch(word) for word in words):  # the words are of other variables
        values = _in_rows([float(word) for word in words], raw)
        return ColumnGuess(column, name, unit, "likely", "its name", values)
    if (loads := _or_nothing(column, name, unit, raw)) is not None:
        return loads
    weighed = _with_units(column, name, words, raw) or _among_words(column, name, words, raw)
    weighed = weighed or _added_up(column, name, words, raw)
    if weighed is not None:
        return weighed
    sides = {axis for axis, _ in sides_in(different[:FEW]).values()}
    if len(different) <= FEW and len(sides) >= SIDES and None not in sides:
        name = replace(name, quantity="orientation")
    directed = directions_of(different)
    if directed or name.quantity == "direction":
        name = replace(name, quantity="direction")
    elif name.quantity not in ("label", "orientation", "placement", "session"):
        kind = "label" if 1 < len(different) <= FEW and len(words) > len(different) else "other"
        if name.quantity in ("reading", "unknown", "load", "sequence") and kind == "label":
            name = replace(name, quantity="label")
        elif name.quantity == "repeat" and kind == "label":
            name = replace(name, quantity="session")
        else:
            name = replace(name, quantity="other")
    codes = np.full(len(raw.values), -1)
    if len(different) <= _MOST_WORDS:
        at = {word: i for i, word in enumerate(different)}
        codes[~raw.empty] = [at[word] for word in words]
    return ColumnGuess(
        column, name, None, "likely", "texts", words=different, codes=codes, names=directed
    )


def directions_of(words: Sequence[str]) -> dict[str, str]:
    """Words for weights that are put on or taken off -> 1 or −1; empty unless both are said."""
    small = {word: word.strip("↑↓ .").lower() for word in words}
    for known in (DIRECTIONS, *LETTERS):
        signs = {word: known.get(said, "") for word, said in small.items()}
        if {*signs.values()} == {"1", "-1"}:
            return signs
    return {}


def _or_nothing(
    column: str, name: NameGuess, unit: str | None, raw: RawColumn
) -> ColumnGuess | None:
    """Loads as plain numbers, and words where none lay: ``500``, ``empty``; None for all others."""
    if name.quantity != "load" or raw.empty.any():
        return None
    said = [str(value).strip() for value in raw.values.tolist()]
    none = tuple(dict.fromkeys(word for word in said if says_nothing(word)))
    numbers = [word for word in said if word not in none]
    if not none or not all(_DECIMAL.fullmatch(word) for word in numbers) or len({*numbers}) < 2:
        return None
    values = np.array([0.0 if w in none else float(w.replace(",", ".")) for w in said])
    why = f"its name; {', '.join(none)} is a load of 0"
    return ColumnGuess(column, name, unit, "likely", why, values, names=dict.fromkeys(none, "0"))


def _full_scale(number: int) -> bool:
    """Whether a number is the largest of a converter, or a power of ten."""
    ends = number & (number + 1) == 0 or number & (number - 1) == 0
    return ends or re.fullmatch("10+", str(number)) is not None


def part_of_the_words(column: ColumnGuess) -> ColumnGuess:
    """In lines of words a number that never changes is one of the words."""
    if column.values is None:
        return column
    some = column.values[np.isfinite(column.values)]
    if some.size and np.ptp(some) > 0:
        return column
    return column.as_quantity("other", "likely", "never changes")


def _with_units(
    column: str, name: NameGuess, words: list[str], raw: RawColumn
) -> ColumnGuess | None:
    """A column of numbers with their units beside them; None where it is none.

    Mostly empty cells are events: what was put on there holds.
    """
    if raw.empty.mean() > _EVENTS:
        return None
    pairs = [with_unit(word) for word in words]
    plain = [word for word, pair in zip(words, pairs, strict=True) if pair is None]
    if not words or not any(pairs) or any(word.strip("0., ") for word in plain):
        return None
    units = {known_unit(pair[1]) for pair in pairs if pair}
    if None in units:
        return None
    kind: Quantity = "load" if name.quantity in ("unknown", "label", "other") else name.quantity
    if kind == "load" and units <= set(TIMES):
        kind = "time"
    elif kind == "load" and units <= set(NO_READING):
        kind = "other"
    elif kind == "load" and units <= VOLTAGES.keys():
        kind = "reading"
    name = replace(name, quantity=kind)
    if len(units) == 1 and not plain:
        unit = units.pop()
        numbers = np.array([float(p[0].replace(",", ".")) for p in pairs if p])
        return ColumnGuess(
            column, name, unit, "likely", "numbers with their unit", _in_rows(numbers, raw),
            pattern=r"([-+]?[\d.,]+(?:[eE][-+]?\d+)?)",
        )  # fmt: skip
    kinds = (("kg", MASSES), ("N", WEIGHTS), ("mV", VOLTAGES))
    one, sizes = next((k for k in kinds if units <= k[1].keys()), ("", {}))
    if not one:
        return None
    numbers = np.array([
        float(p[0].replace(",", ".")) * sizes[known_unit(p[1]) or one] if p else 0.0 for p in pairs
    ])  # fmt: skip
    return ColumnGuess(
        column, name, one, "likely", "numbers with their units", _in_rows(numbers, raw),
        pattern=r"([-+]?[\d.,]+(?:[eE][-+]?\d+)?)\s*(?P<unit>[A-Za-zµ]*)",
    )  # fmt: skip


def _added_up(column: str, name: NameGuess, words: list[str], raw: RawColumn) -> ColumnGuess | None:
    """Weights that were put together, or none at all: ``1 lb + 2.5 lb``, ``empty``.

    Cells between may be empty, as in a column of events: what was put on holds until the next one.
    """
    different = tuple(dict.fromkeys(words))
    held = bool(raw.empty.any())
    if not 1 < len(different) <= FEW:
        return None
    if name.quantity not in ("load", "unknown", "label", "other", "reading"):
        return None
    others = tuple(word for word in different if said_weight(word) is None)
    rows = sum(word in others for word in words)
    if others and (held or name.quantity != "load" or rows > _RARE * len(words)):
        return None
    found = sums_of(word for word in different if word not in others)
    if found is None:
        return None
    loads, unit = found
    values = np.array([loads.get(word, np.nan) for word in words])
    if np.nanmax(values) == np.nanmin(values):
        return None
    at = np.cumsum(~raw.empty) - 1
    values = np.where(at < 0, np.nan, values[at])
    why = "weights in words, added up" + ", held until the next one" * held
    why += f"; {', '.join(others)} is none, such rows are left out" if others else ""
    return ColumnGuess(
        column, replace(name, quantity="load"), unit, "likely", why,
        values, names={word: f"{load:.10g}" for word, load in loads.items()}, missing=others,
        held=held, codes=_where_typed(words, tuple(loads), raw) if held else None,
    )  # fmt: skip


def _where_typed(words: list[str], different: tuple[str, ...], raw: RawColumn) -> IntArray:
    """Which of some texts stands in each row, −1 where none does, shape (n,)."""
    codes = np.full(len(raw.values), -1)
    codes[~raw.empty] = [different.index(word) for word in words]
    return codes


def taking_turns(column: ColumnGuess) -> ColumnGuess:
    """Numbers that come again and again in the same order are of what stands beside them.

    Registers, as a master of Modbus prints them: ``[101]: 8347750``, ``[103]: 8123411``.
    """
    values = column.values
    if values is None or column.quantity not in ("reading", "unknown"):
        return column
    period = int(np.argmax(values[1:] == values[0])) + 1 if values.size > 1 else 0
    once = values[:period]
    if not 1 < period <= min(FEW, values.size // _TURNS) or np.unique(once).size < period:
        return column
    if not np.array_equal(values, np.resize(once, values.size)) or np.any(once != np.round(once)):
        return column
    words = tuple(f"{value:.0f}" for value in once)
    return ColumnGuess(
        column.column, NameGuess("label"), None, "likely", "numbers that take turns",
        words=words, codes=np.resize(np.arange(period), values.size),
    )  # fmt: skip


def numbers_as_labels(values: FloatArray, largest: float = FEW) -> ColumnGuess | None:
    """Small whole numbers that take turns, as sensors are counted; None where they are no labels.

    Parameters
    ----------
    values
        Of a column that is called after a sensor or a leg, shape (n,).
    largest
        Of these numbers; settings of an amplifier are larger than the numbers of sensors.
    """
    good = values[np.isfinite(values)]
    if good.size < values.size or np.any(good != np.round(good)):
        return None
    different = list(dict.fromkeys(good.tolist()))
    if not 1 < len(different) <= min(FEW, good.size // 2) or not 0 <= max(different) <= largest:
        return None
    codes = np.array([different.index(value) for value in good.tolist()])
    words = tuple(f"{value:.0f}" for value in different)
    return ColumnGuess(
        "", NameGuess("label"), None, "likely", "numbers of sensors", words=words, codes=codes
    )


def one_after_the_other(values: FloatArray) -> bool:
    """Whether numbers count up from 0 or 1, some rows of each, and begin again, if at all."""
    if values.size < 2 * _LEAST_OF_ONE or values[0] not in (0.0, 1.0):
        return False
    at = np.flatnonzero(np.diff(values))
    steps, begin = np.diff(values)[at], values[at + 1]
    runs = np.diff(np.concatenate([[-1], at, [values.size - 1]]))
    up = (steps == 1.0) | (begin == values[0])
    return bool(at.size and np.all(up) and runs.min() >= _LEAST_OF_ONE)


def _among_words(
    column: str, name: NameGuess, words: list[str], raw: RawColumn
) -> ColumnGuess | None:
    """A weight with its unit among the words of each cell (``ST,+0500.0 g``, ``load 2 kg``).

    Cells between may be empty, as in a column of events: what was put on holds until the next one.
    """
    found = [IN_WORDS.findall(word) for word in words]
    units = {known_unit(one[0][1]) for one in found if len(one) == 1}
    if not words or len(units) != 1 or any(len(one) != 1 for one in found):
        return None
    if any(re.search(r"[-+]\s+\d", word) for word in words):
        return None  # a sign apart from its number would be lost
    if name.quantity not in ("load", "unknown", "label", "other", "reading"):
        return None
    weights = np.array([float(one[0][0].replace(",", ".")) for one in found])
    if np.ptp(weights) == 0.0:
        return None
    held = bool(raw.empty.any())
    at = np.cumsum(~raw.empty) - 1
    values = np.where(at < 0, np.nan, weights[at]) if held else weights
    spelled = found[0][0][1]
    return ColumnGuess(
        column, replace(name, quantity="load"), units.pop(), "likely",
        "a weight among words" + (", held until the next one" if held else ""), values,
        pattern=rf"(?<![\w.+-])(?<!\d,)([-+]?\d+(?:[.,]\d+)?)\s*{spelled}(?!\w)", held=held,
    )  # fmt: skip


def _serials(words: Sequence[str]) -> bool:
    """Whether words are one letter and decimals, as serial numbers: ``B211``, ``B214``."""
    return len({word[0] for word in words}) == 1 and all(
        re.fullmatch(r"[A-Za-z]\d+", word) for word in words
    )
