"""A cell of a bench unlike all others; of the room of the session, asked by fit and diagnosis."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from footcal_cli.core.bench_rows import check_uneven
from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.quality import Finding
from footcal_cli.tables.table import Table


def uneven(tables: Sequence[Table]) -> list[Finding]:
    """A cell that lies off its line far more than all others, by the rows of all its sessions."""
    if not tables:
        return []
    channel = np.concatenate([table.text("channel") for table in tables])
    load, counts = (
        np.concatenate([table.number(name) for table in tables]) for name in ("load_n", "counts")
    )
    names, which = np.unique(channel, return_inverse=True)
    sessions = sessions_in_order(tables)
    return check_uneven(load, counts, which.astype(np.float64), sessions, [*map(str, names)])


def sessions_in_order(tables: Sequence[Table]) -> FloatArray:
    """Number of the session of every row: file by file, and within a file by its column."""
    labels = [
        f"{number} {text}"
        for number, table in enumerate(tables)
        for text in (table.text("session") if "session" in table else [""] * len(table))
    ]
    order = {label: float(i) for i, label in enumerate(dict.fromkeys(labels))}
    return np.array([order[label] for label in labels])
