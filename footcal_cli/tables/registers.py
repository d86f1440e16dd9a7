"""Readings that stand in two registers of sixteen bits, as Modbus and CANopen transmit them.

Room: tables; called by sources.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from footcal_cli.core.parameters import FloatArray
from footcal_cli.errors import DataError
from footcal_cli.tables.rawcolumn import RawColumn

WORD = 65536
"""Codes of a register."""


def thirty_two_bits(high: FloatArray, low: FloatArray) -> FloatArray:
    """Signed numbers of two registers, shape (n,): ``65536 high + low``, `high` with the sign.

    >>> thirty_two_bits(np.array([0.0, 65535.0]), np.array([7.0, 65535.0])).tolist()
    [7.0, -1.0]
    """
    signed = np.where(high >= WORD / 2, high - WORD, high)
    return np.asarray(signed * WORD + np.where(low < 0, low + WORD, low))


def with_high_word(
    low: RawColumn, high: RawColumn, names: tuple[str, str], path: Path
) -> RawColumn:
    """A column of low words with the one of high words beside it.

    Raises
    ------
    DataError
        One of them holds something else than numbers of sixteen bits.
    """
    for raw, name in zip((low, high), names, strict=True):
        good = raw.kind == "number" and np.all(
            raw.empty | ((np.abs(raw.values) < WORD) & (raw.values == np.round(raw.values)))
        )
        if not good:
            raise DataError("holds no registers of 16 bits", file=path, column=name,
                            remedy="correct `high_word` in [columns]")  # fmt: skip
    values = thirty_two_bits(high.values.astype(np.float64), low.values.astype(np.float64))
    empty = low.empty | high.empty
    if empty.any():
        return replace(low, values=np.where(empty, np.nan, values), empty=empty)
    return replace(low, values=values.astype(np.int64))
