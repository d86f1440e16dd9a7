"""Evidence given twice: rows that another log of the same run, or the log itself, has already.

Copies would shrink every sd as if they had been measured. A row counts by its content: file name,
format, order of columns and rows, and the number of a session or repetition do not matter.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from footcal_cli.core.parameters import BoolArray, FloatArray
from footcal_cli.core.quality import Finding
from footcal_cli.tables.table import Table

if TYPE_CHECKING:
    import pandas as pd

COPIED_SHARE = 0.9
"""Logs share rows by chance only below this share of the shorter one."""
FEWEST_SHARED_STAMPS = 5
"""Rows with equal stamps that must agree before overlapping recordings are called copies."""
_SAME_DIGITS = 8
"""Copies agree to so many significant digits, whatever their format and unit."""
_STAMP_STEP_S = 1e-6
_LABELS = frozenset({"session", "repeat"})
"""Columns that tell recordings apart; a copy may bear another label."""

_BY_CHANCE = 1e-6
"""Probability that as many rows repeat by chance, from which they were written twice."""
_LEAST_CHANCE, _SHORTEST_BLOCK = 1e-3, 3
"""Least probability of an equal reading, however rare they are in the log; rows of a block."""

Hashes = NDArray[np.uint64]


@dataclass(frozen=True)
class Fingerprint:
    """The rows of a log without its format.

    Parameters
    ----------
    name
        File name.
    columns
        Columns that count.
    rows
        Hash of every row, shape (n,).
    stamps
        Hash of every row's stamp and texts, shape (n,); None without stamps.
    labels
        Hash of every row's session and repetition, shape (n,).
    settings, readings
        Without stamps: hash of every row's other columns and of its counts, shape (n,); empty with
        stamps, which tell rows apart.
    """

    name: str
    columns: tuple[str, ...]
    rows: Hashes
    stamps: Hashes | None
    labels: Hashes
    settings: Hashes
    readings: Hashes


def fingerprint(table: Table) -> Fingerprint:
    """The fingerprint of a log."""
    import pandas as pd

    data = table.data.drop(columns=[n for n in table.data.columns if n in _LABELS])
    hashes = {str(name): _column_hashes(data[name], str(name)) for name in sorted(data.columns)}
    stamps = None
    others = read = np.zeros(0, dtype=np.uint64)
    if "time_s" in hashes:
        texts = [n for n in hashes if not pd.api.types.is_numeric_dtype(data[n])]
        stamps = _joined([hashes[name] for name in ("time_s", *texts)])
    else:
        none = np.zeros(len(table), dtype=np.uint64)
        read, others = (
            _joined([none, *(h for name, h in hashes.items() if name.endswith("counts") is own)])
            for own in (True, False)
        )
    labels = [_column_hashes(table.data[n], n) for n in sorted(_LABELS & set(table.data.columns))]
    labelled = _joined(labels) if labels else np.zeros(len(table), dtype=np.uint64)
    return Fingerprint(
        table.path.name, tuple(hashes), _joined(list(hashes.values())), stamps, labelled, others,
        read,
    )  # fmt: skip


def find_copied_rows(log: Fingerprint, earlier: Fingerprint) -> BoolArray:
    """Rows of a log that stand in an earlier one, shape (n,).

    A row that stands there k times accounts for k rows. Few common rows are chance (coarse
    readings repeat themselves): unless `COPIED_SHARE` of the shorter log, or of the rows with
    equal stamps, is common, none counts as a copy.
    """
    none = np.zeros(log.rows.size, dtype=np.bool_)
    if log.columns != earlier.columns:
        return none
    common = _contained(log.rows, earlier.rows)
    shared = int(common.sum())
    if shared and shared >= COPIED_SHARE * min(log.rows.size, earlier.rows.size):
        return common
    if log.stamps is not None and earlier.stamps is not None:
        same_stamp = int(_contained(log.stamps, earlier.stamps).sum())
        if same_stamp >= FEWEST_SHARED_STAMPS and shared >= COPIED_SHARE * same_stamp:
            return common
    return none


def repeated_rows(log: Fingerprint) -> BoolArray:
    """Rows of a log in which every row is a reading of its own that are copies, shape (n,).

    With stamps: rows that stand in their session before, and sessions that are copies of earlier
    ones. Stamps may start anew in every session, so that coarse readings of two sessions agree by
    chance. Without stamps: blocks of rows that stood there before.
    """
    if log.stamps is None:
        return _blocks_again(log)
    copied = np.ones(log.rows.size, dtype=np.bool_)
    copied[np.unique(_joined([log.labels, log.rows]), return_index=True)[1]] = False
    seen: set[bytes] = set()
    for label in dict.fromkeys(log.labels.tolist()):
        mine = np.flatnonzero((log.labels == label) & ~copied)
        content = np.sort(log.rows[mine]).tobytes()
        copied[mine] = content in seen
        seen.add(content)
    return copied


def _blocks_again(log: Fingerprint) -> BoolArray:
    """Rows of a block that stood in the log before, in the same order, shape (n,).

    A block is as long as chance would not repeat: equal readings under the same load happen with
    a probability that the log itself shows.
    """
    n = log.rows.size
    found = np.zeros(n, dtype=np.bool_)
    same, pairs = _pairs_alike(log.rows), _pairs_alike(log.settings)
    equal = float(np.clip(same / max(pairs, 1), _LEAST_CHANCE, 1.0))
    needed = np.log(_BY_CHANCE / n**2) / np.log(equal) if n and equal < 1.0 else np.inf
    length = max(int(np.ceil(needed)), _SHORTEST_BLOCK) if np.isfinite(needed) else n
    if length > n // 2 or not n:
        return found
    number = np.unique(log.rows, return_inverse=True)[1]
    windows = np.lib.stride_tricks.sliding_window_view(number, length)
    _, first, which = np.unique(windows, axis=0, return_index=True, return_inverse=True)
    for start in np.flatnonzero(np.arange(len(windows)) - first[which.ravel()] >= length):
        if np.unique(log.readings[start : start + length]).size > 2:
            found[start : start + length] = True
    return found


def _pairs_alike(values: Hashes) -> int:
    """Pairs of equal values."""
    _, often = np.unique(values, return_counts=True)
    return int((often * (often - 1)).sum())


def without_copies(
    tables: Sequence[Table], earlier: Sequence[Table] = (), *, within: bool = False
) -> tuple[list[Table | None], list[Finding]]:
    """Take out of logs of one kind what a longer one, or an earlier one, holds already.

    Parameters
    ----------
    tables
        Logs of one kind.
    earlier
        Logs of the same kind that were read before.
    within
        Whether rows may also be copies of rows of the same log.

    Returns
    -------
    kept
        The logs in their order; None for one that is a copy, all but a few of its rows at most.
    findings
        One per log with copied rows.
    """
    kept: list[Table | None] = list(tables)
    if len(tables) + len(earlier) < 2 and not within:
        return kept, []
    known, found = [fingerprint(table) for table in earlier], {}
    for i in sorted(range(len(tables)), key=lambda i: -len(tables[i])):
        own = fingerprint(tables[i])
        copied = repeated_rows(own) if within else np.zeros(own.rows.size, dtype=np.bool_)
        first = own.name if copied.any() else ""
        for other in known:
            rows = find_copied_rows(own, other)
            first = first or (other.name if rows.any() else "")
            copied |= rows
        known.append(own)
        if not copied.any():
            continue
        rest = tables[i].data[~copied].reset_index(drop=True)
        # what remains of a copied recording is no recording
        least = 0 if own.stamps is None else (1 - COPIED_SHARE) * copied.size
        kept[i] = replace(tables[i], data=rest) if len(rest) > least else None
        found[i] = _finding(tables[i], first, int(copied.sum()), left_out=kept[i] is None)
    return kept, [found[i] for i in sorted(found)]


def _finding(table: Table, other: str, copied: int, *, left_out: bool) -> Finding:
    name, rows = table.path.name, len(table)
    how_many = f"all {rows} rows are" if copied == rows else f"{copied} of {rows} rows are"
    whose = "earlier ones" if other == name else f"rows of {other}"
    then = "it is left out" if left_out else "they count once"
    return Finding(
        "rows_given_twice", "warning", name,
        f"{name}: {how_many} a copy of {whose}; {then}", "give every recording once",
    )  # fmt: skip


def _contained(rows: Hashes, earlier: Hashes) -> BoolArray:
    """Rows that also occur in `earlier`, each as often as it occurs there, shape (n,)."""
    values, index = np.unique(np.concatenate([rows, earlier]), return_inverse=True)
    own = index[: rows.size]
    available = np.bincount(index[rows.size :], minlength=values.size)
    order = np.argsort(own, kind="stable")
    starts = np.searchsorted(own[order], own[order], side="left")
    rank = np.empty(rows.size, dtype=np.int64)
    rank[order] = np.arange(rows.size) - starts
    return np.asarray(rank < available[own])


def _column_hashes(column: pd.Series[Any], name: str) -> Hashes:
    import pandas as pd

    values: pd.Series[Any] = column.astype(str)
    if pd.api.types.is_numeric_dtype(column):
        numbers = np.asarray(column, dtype=np.float64)
        if name == "time_s":  # an absolute stamp has its seconds behind ten digits
            values = pd.Series(np.round(numbers / _STAMP_STEP_S))
        else:
            values = pd.Series(_rounded(numbers))
    return np.asarray(pd.util.hash_pandas_object(values, index=False), dtype=np.uint64)


def _joined(hashes: Sequence[Hashes]) -> Hashes:
    """One hash of several per row, depending on their order."""
    joined = np.zeros(hashes[0].size, dtype=np.uint64)
    for column in hashes:
        joined = (joined ^ column) * np.uint64(0x9E3779B97F4A7C15)  # wraps round, as hashes do
        joined ^= joined >> np.uint64(29)
    return joined


def _rounded(values: FloatArray) -> FloatArray:
    """Values to `_SAME_DIGITS` significant digits; −0 is 0, and all NaN are one."""
    size = np.abs(values)
    with np.errstate(divide="ignore", invalid="ignore"):
        step = 10.0 ** (np.floor(np.log10(size)) + 1 - _SAME_DIGITS)
        rounded = np.round(values / step) * step
    return np.asarray(np.where(size > 0, rounded, np.where(np.isnan(values), np.nan, 0.0)))
