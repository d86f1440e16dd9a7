"""Whether a walk is too long to be held; asked before anything heavy is imported."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from footcal_cli.tables.columns import TableType, body_table, cells_table
from footcal_cli.tables.table import Table, read_pieces

if TYPE_CHECKING:
    from footcal_cli.session.session import Session

LONG_S = 1200.0
"""Walks longer than this are run in parts."""
_LEAST_BYTES = 2**19
"""A smaller log of eight cells holds no walk of that length."""


def is_long_walk(session: Session[Any]) -> bool:
    """Whether the session has one sensor log longer than `LONG_S`, and one body log."""
    robot = session.recipe.robot
    if not robot.feet or robot.mass_kg is None or not robot.cell_names:
        return False
    cells = cells_table(robot.cell_names)
    path = session.only_log(cells, "cells")
    body = session.only_log(body_table(tuple(robot.feet)), "body")
    if path is None or body is None or not path.is_file() or path.stat().st_size < _LEAST_BYTES:
        return False
    first = None
    for table in pieces_of(session, path, cells):
        time_s = table.number("time_s")
        first = float(np.nanmin(time_s)) if first is None else first
        if float(np.nanmax(time_s)) - first > LONG_S:
            return True
    return False


def pieces_of(session: Session[Any], path: Path, table: TableType) -> Iterator[Table]:
    """A log some rows at a time, nothing noted."""
    reading, robot = session.recipe.reading(path), session.recipe.robot
    return read_pieces(path, table, reading, gravity_mps2=robot.gravity_mps2)
