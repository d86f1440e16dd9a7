"""Every name that footcal gives a column: what ``[columns]`` of a recipe may map."""

from __future__ import annotations

from collections.abc import Sequence

from footcal_cli.tables.columns import (
    AXIS_COLUMNS,
    NINE,
    TableType,
    base_columns,
    body_table,
    cells_table,
    cop_points_table,
    hang_table,
    legs_table,
    placements_table,
    poses_table,
    truth_table,
    weights_stream_table,
    weights_table,
    weights_together_table,
)

_ENDINGS = (
    "_counts", *(f"_{axis}" for axis in AXIS_COLUMNS), *(f"_foot_{a}_m" for a in "xyz"),
    *(f"_foot_{angle}_rad" for angle in ("roll", "pitch", "yaw")),
    *(f"_foot_q{a}" for a in "xyzw"), *(f"_foot_r{n}" for n in NINE),
    "_cop_x_m", "_cop_y_m",
)  # fmt: skip
"""Endings of columns that are named after a channel, a foot or a transducer."""


def canonical_names(cells: Sequence[str]) -> set[str]:
    """Every canonical column that some log of a robot may have, but for those of `_ENDINGS`.

    Parameters
    ----------
    cells
        Names of the robot's load cells, alone and with their foot; their readings are included.
    """
    tables = (
        weights_table(), weights_stream_table(cells), weights_together_table(cells),
        weights_together_table(cells, known_wrench=True), cop_points_table(),
        placements_table(cells), cells_table(cells), truth_table(cells), body_table(()),
        hang_table(), legs_table(), poses_table(), TableType("base", base_columns()),
    )  # fmt: skip
    return {column.name for table in tables for column in table.columns}


def is_canonical(name: str, cells: Sequence[str]) -> bool:
    """Whether some log may have a column of this name, given the cells that the recipe names."""
    if name in canonical_names(cells):
        return True
    of_a_sensor = any(name.endswith(f"_{axis}") for axis in AXIS_COLUMNS)
    if not of_a_sensor and (name.endswith("_n") or (cells and name.endswith("_counts"))):
        return False  # forces have a cell of the recipe; readings too where it lists its cells
    return any(name.endswith(ending) and name != ending for ending in _ENDINGS)
