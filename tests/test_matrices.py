"""Feet whose orientation is logged as a rotation matrix, and files that share a stem."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from scipy.spatial.transform import Rotation

from footcal_cli.errors import DataError
from footcal_cli.tables.columns import body_table
from footcal_cli.tables.reading import ForeignColumn, Join, Layout, Reading
from footcal_cli.tables.sources import source_columns
from footcal_cli.tables.table import read_table


def _written(path: Path, matrices: np.ndarray[tuple[int, ...], np.dtype[np.float64]]) -> Path:
    rows = len(matrices)
    columns = {"time_s": 0.01 * np.arange(rows), **{f"com_{a}_m": np.ones(rows) for a in "xyz"}}
    columns |= {f"left_foot_{a}_m": np.zeros(rows) for a in "xyz"}
    columns |= {f"left_foot_r{i + 1}{j + 1}": matrices[:, i, j] for i, j in np.ndindex(3, 3)}
    pd.DataFrame(columns).to_csv(path, index=False)
    return path


def test_a_matrix_is_read_as_its_quaternion(tmp_path: Path) -> None:
    turned = Rotation.from_rotvec(np.linspace(-1.0, 1.0, 30).reshape(10, 3))
    table = read_table(
        _written(tmp_path / "body.csv", turned.as_matrix()),
        body_table(("left",)),
        gravity_mps2=9.81,
    )
    four = table.numbers([f"left_foot_q{a}" for a in "xyzw"])
    assert np.allclose(Rotation.from_quat(four).as_matrix(), turned.as_matrix(), atol=1e-9)


def test_a_matrix_that_mirrors_is_refused_by_its_row(tmp_path: Path) -> None:
    matrices = np.tile(np.eye(3), (5, 1, 1))
    matrices[3, 0, 0] = -1.0
    with pytest.raises(DataError, match="left_foot_r11 … left_foot_r33 are no rotation") as caught:
        read_table(
            _written(tmp_path / "body.csv", matrices), body_table(("left",)), gravity_mps2=9.81
        )
    assert caught.value.row == "row 4 of the data"


def test_files_of_one_stem_are_joined_by_their_whole_names(tmp_path: Path) -> None:
    for end, values in {"com": "0 1\n1 2\n", "lsole": "0 5\n1 6\n", "rsole": "0 7\n1 8\n"}.items():
        (tmp_path / f"walk.{end}").write_text(values)
    bare = Reading(layout=Layout(separator=" ", header=False))
    bare = replace(bare, columns={"time_s": ForeignColumn("column_1", "s")})
    joins = tuple(Join(tmp_path / f"walk.{end}", bare) for end in ("lsole", "rsole"))
    places = {"a": ForeignColumn("walk.lsole.column_2"), "b": ForeignColumn("walk.rsole.column_2")}
    reading = replace(bare, joins=joins)
    found = source_columns(tmp_path / "walk.com", reading, places, frozenset())
    assert [list(found[name].values) for name in "ab"] == [[5, 6], [7, 8]]
