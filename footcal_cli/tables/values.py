"""Raw columns as the numbers, texts and stamps that a table type asks for; or one line why not."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from footcal_cli.errors import DataError
from footcal_cli.tables.columns import Column
from footcal_cli.tables.rawcolumn import RawColumn
from footcal_cli.tables.textfiles import short
from footcal_cli.tables.units import NOT_SAID

if TYPE_CHECKING:
    import pandas as pd

EXACT = 2**53
"""Integers up to here are exact as float64."""
_NARROW = 2**30
"""Of integers below it 32 bits hold differences, too."""
_LARGEST, _LARGEST_LOAD = 1e30, 1e12
"""No reading is larger, and no load in any unit; of a stream samples beyond sense are left out."""
_DAY_NS = 86_400 * 10**9
_TRUE_AND_FALSE = {"true": 1.0, "false": 0.0}
HEXADECIMAL = r"0[xX][0-9A-Fa-f]{1,12}"
"""A register of a converter as it was printed."""
_LETTERS = frozenset("ABCDEFabcdef")
_DIGITS = _LETTERS | frozenset("0123456789")
_MOST_DIGITS = 12
_ISO = re.compile(r"\d{4}-\d\d-\d\d[T ]\d\d:\d\d")
_UTC = re.compile(r"\s*(?:UTC|GMT)$")
_ZONE = re.compile(r":\d\d(?:\.\d*)?\s?(?:Z|[+-]\d\d(?::?\d\d)?)$")


def texts(raw: RawColumn, spec: Column, name: str, path: Path) -> NDArray[np.object_]:
    """One column as strings, shape (n,)."""
    if raw.empty.any() and spec.missing == "refuse":
        row = raw.row(int(np.argmax(raw.empty)))
        raise DataError(
            "empty cell", file=path, column=name, row=row, remedy=f"fill in {spec.meaning}"
        )
    return np.array([str(value).strip() for value in raw.values.tolist()], dtype=object)


def numbers(raw: RawColumn, spec: Column, name: str, unit: str | None, path: Path) -> NDArray[Any]:
    """One column as numbers (n,), integers kept as they are; the first bad cell is named."""
    if raw.kind == "truth":
        if spec.flag and not raw.empty.any():
            return raw.values.astype(np.int64)
        _refuse("true and false are not numbers", np.ones(1, bool), raw, spec, name, unit, path)
    if raw.kind in ("stamp", "duration"):
        raise DataError(
            "the column holds dates or durations, not numbers", file=path, column=name,
            remedy=f"the column is {spec.meaning}",
        )  # fmt: skip
    values = raw.values
    if raw.kind == "text":
        values = _parsed(raw, spec, name, unit, path)
    if values.dtype.kind in "iu":
        large = (values > EXACT) | ((values < -EXACT) if values.dtype.kind == "i" else False)
        _refuse(
            "an integer above 2^53, which no calculation keeps exactly",
            np.asarray(large), raw, spec, name, unit, path,
        )  # fmt: skip
    else:
        values = values.astype(np.float64, copy=False)
        if spec.missing == "refuse":
            _refuse("empty cell or NaN", np.isnan(values), raw, spec, name, unit, path)
        _refuse("infinite value", np.isinf(values), raw, spec, name, unit, path)
    rows_count = spec.missing == "refuse" and spec.unit != "s"
    largest = EXACT if spec.unit == "count" else _LARGEST_LOAD if rows_count else _LARGEST
    with np.errstate(invalid="ignore"):
        huge = (values > largest) | (values < -largest)
    _refuse("too large to be a reading", huge, raw, spec, name, unit, path)
    return values


def narrowed(frame: pd.DataFrame) -> pd.DataFrame:
    """Integers in half the memory where 32 bits hold them and their differences: exact."""
    return frame.astype(
        {
            name: np.int32
            for name, column in frame.items()
            if column.dtype == np.int64 and column.min() > -_NARROW and column.max() < _NARROW
        }
    )


def stamps(
    raw: RawColumn, spec: Column, name: str, unit: str | None, path: Path,
    form: str | None = None,
) -> NDArray[np.int64] | None:  # fmt: skip
    """Stamps of a time column as integer nanoseconds (n,); None where it holds other numbers.

    Dates count from 1970 in UTC; without a zone they are taken as UTC. `form` is theirs as
    ``strptime`` has it; a time of day without a date counts from midnight.
    """
    import pandas as pd

    if spec.unit != "s":
        return None
    if form is not None:
        return _formatted(raw, spec, name, path, form)
    if raw.kind == "stamp":
        _refuse("no stamp", raw.empty, raw, spec, name, None, path)
        return raw.values
    if raw.kind == "number" and raw.values.dtype.kind in "iu" and unit == "ns":
        return raw.values.astype(np.int64) if raw.values.max() < 2**63 else None
    if raw.kind != "text" or raw.empty.all():
        return None
    words = raw.values
    if _ISO.match(str(words[int(np.argmin(raw.empty))]).strip()) is None:
        return None
    _refuse("no stamp", raw.empty, raw, spec, name, None, path)
    # ISO 8601 has the decimal comma too, pandas has not
    trimmed = pd.Series([_UTC.sub("Z", str(word).strip().replace(",", ".")) for word in words])
    zoned = np.array([_ZONE.search(word) is not None for word in trimmed])
    if zoned.any():
        _refuse("a stamp without time zone among others", ~zoned, raw, spec, name, None, path)
    dates = pd.to_datetime(trimmed, format="ISO8601", utc=True, errors="coerce")
    _refuse("not a date", dates.isna().to_numpy(), raw, spec, name, None, path)
    outside = ~dates.dt.year.between(1678, 2261).to_numpy()
    _refuse("a date outside the years 1678 to 2261", outside, raw, spec, name, None, path)
    return np.asarray(dates.dt.tz_localize(None).astype("datetime64[ns]").astype(np.int64))


def _formatted(raw: RawColumn, spec: Column, name: str, path: Path, form: str) -> NDArray[np.int64]:
    """Stamps of another form than ISO 8601, shape (n,)."""
    import pandas as pd

    _refuse("no stamp", raw.empty, raw, spec, name, None, path)
    words = pd.Series([str(word).strip() for word in raw.values.tolist()])
    try:
        dates = pd.to_datetime(words, format=form, errors="coerce", utc=True)
    except ValueError as error:
        raise DataError(
            f"format '{form}' of [columns] is none: {error}", file=path, column=name,
            remedy="write it as strptime has it, such as %d.%m.%Y %H:%M:%S.%f",
        ) from None  # fmt: skip
    _refuse(f"not of the format '{form}'", dates.isna().to_numpy(), raw, spec, name, None, path)
    found = np.asarray(dates.dt.tz_localize(None).astype("datetime64[ns]").astype(np.int64))
    if "%d" in form or "%j" in form or "%b" in form:
        return found
    # a time of day: past midnight another day begins
    found = found - int(pd.Timestamp(1900, 1, 1).value)
    return np.asarray(found + _DAY_NS * np.cumsum(np.diff(found, prepend=found[0]) < -_DAY_NS // 2))


def since_the_first(raw: RawColumn, form: str) -> NDArray[np.float64]:
    """Seconds since the first of some dates, shape (n,); NaN where there is none."""
    import pandas as pd

    words = pd.Series(
        [None if e else str(v).strip() for v, e in zip(raw.values, raw.empty, strict=True)]
    )
    dates = pd.to_datetime(words, format=form, errors="coerce", utc=True)
    return np.asarray((dates - dates.dropna().min()).dt.total_seconds(), dtype=np.float64)


def durations(raw: RawColumn, spec: Column, name: str, path: Path) -> NDArray[np.float64] | None:
    """A column of durations as seconds (n,); None where it holds something else."""
    if spec.unit != "s" or raw.kind != "duration":
        return None
    _refuse("empty cell", raw.empty, raw, spec, name, None, path)
    return seconds(raw.values)


def seconds(nanoseconds: NDArray[np.int64]) -> NDArray[np.float64]:
    """Integer nanoseconds as seconds (n,): whole ones and the rest apart; dates keep 0.2 µs."""
    whole, rest = np.divmod(nanoseconds, 10**9)
    return whole.astype(np.float64) + rest.astype(np.float64) / 1e9


def _parsed(raw: RawColumn, spec: Column, name: str, unit: str | None, path: Path) -> NDArray[Any]:
    """Strings that are numbers; a flag may be written true and false."""
    import pandas as pd

    words = pd.Series(
        [None if e else str(v).strip() for v, e in zip(raw.values, raw.empty, strict=True)],
        dtype=object,
    )
    if spec.flag:
        words = words.map(lambda word: _TRUE_AND_FALSE.get(str(word).lower(), word))
    if path.suffix.lower() in {".parquet", ".pq"} and not raw.said:
        _refuse("text, not a number", ~raw.empty, raw, spec, name, unit, path)
    some = words.dropna()
    if some.str.fullmatch(HEXADECIMAL).all() or bare_hexadecimal(some.tolist()):
        words = words.map(lambda word: int(word, 16), na_action="ignore")
    parsed = pd.to_numeric(words, errors="coerce")
    bad = np.asarray(parsed.isna().to_numpy() & ~raw.empty)
    _refuse("not a number", bad, raw, spec, name, unit, path)
    return parsed.to_numpy()


def bare_hexadecimal(words: Sequence[str]) -> bool:
    """Whether words are registers in hexadecimal digits without a mark: as long as each other.

    Some digit is a letter; four digits at least, as no converter that weighs has fewer.
    """
    lengths = {len(word) for word in words}
    return (
        len(lengths) == 1 and 4 <= lengths.pop() <= _MOST_DIGITS
        and all(set(word) <= _DIGITS for word in words)
        and any(set(word) & _LETTERS for word in words)
    )  # fmt: skip


def _refuse(
    problem: str, bad: NDArray[np.bool_], raw: RawColumn, spec: Column, name: str,
    unit: str | None, path: Path,
) -> None:  # fmt: skip
    """Raise for the first bad cell of a column, if there is one."""
    if not bad.any():
        return
    at = int(np.argmax(bad))
    value: object = raw.values[at]
    remedy = "correct the cell or leave the row out"
    if value == NOT_SAID:
        remedy = f"replace every {NOT_SAID} of {spec.name} in the recipe's [columns]"
    raise DataError(
        problem, file=path, column=name, row=raw.row(at),
        value=short(value) if isinstance(value, str) else None if raw.empty[at] else value,
        unit=unit if raw.kind == "number" else None,
        remedy=f"{remedy}; the column is {spec.meaning}",
    )  # fmt: skip
