"""Streams of feet with roll and pitch, of a CoM with its velocity, and benches of both feet."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from scipy.spatial.transform import Rotation

from footcal_cli.core.body_stream import note_differentiated
from footcal_cli.core.signals import slopes_of
from footcal_cli.errors import DataError
from footcal_cli.intake.streams import body_stream_of
from footcal_cli.recipe import read_recipe
from footcal_cli.tables.columns import body_table, weights_table
from footcal_cli.tables.reading import ForeignColumn, Reading
from footcal_cli.tables.table import read_table
from footcal_cli.tables.world import WorldUp

G = 9.80665
ANGLES = ("roll", "pitch", "yaw")


def _log(path: Path, degrees: np.ndarray[tuple[int, int], np.dtype[np.float64]]) -> Path:
    rows = len(degrees)
    columns = {"time_s": np.arange(rows) / 100.0}
    columns |= {f"{stem}_{a}_m": np.zeros(rows) for stem in ("com", "left_foot") for a in "xyz"}
    columns |= {f"com_vel_{a}_mps": np.arange(rows) * i / 100.0 for i, a in enumerate("xyz")}
    columns |= {f"L_{angle}": degrees[:, i] for i, angle in enumerate(ANGLES)}
    pd.DataFrame(columns).to_csv(path, index=False)
    return path


@pytest.mark.parametrize(("up", "signs"), [("+z", (1, 1, 1)), ("-z", (1, -1, -1))])
def test_a_foot_with_roll_and_pitch_in_degrees(
    tmp_path: Path, up: WorldUp, signs: tuple[int, int, int]
) -> None:
    degrees = np.random.default_rng(0).uniform(-40.0, 40.0, (9, 3))
    log = _log(tmp_path / "body.csv", degrees)
    columns = {f"left_foot_{a}_rad": ForeignColumn(f"L_{a}", "deg") for a in ANGLES}
    reading = Reading(columns, world_up=up)
    stream = body_stream_of(
        read_table(log, body_table(("left",)), reading, gravity_mps2=G), ("left",)
    )
    assert stream.feet_rot is not None
    want = Rotation.from_euler("ZYX", (degrees * signs)[:, ::-1], degrees=True).as_matrix()
    np.testing.assert_allclose(stream.feet_rot[:, 0], want, atol=1e-12)
    assert stream.com_vel_mps is not None
    acceleration = slopes_of(stream.com_vel_mps, stream.time_s)
    np.testing.assert_allclose(np.abs(acceleration), np.tile([0.0, 1.0, 2.0], (9, 1)), atol=1e-9)
    said = note_differentiated(stream.com_acc_mps2, velocity=True)
    assert "derivative of its velocity" in said[0].sentence


def test_rows_of_another_foot_are_left_out_and_not_without_a_load(tmp_path: Path) -> None:
    log = tmp_path / "bench.csv"
    log.write_text("foot,cell,kg,c1\nL,1,0,3\nL,1,5,9\nL,2,5,3\nR,1,0,77\nR,1,5,88\n")
    recipe = tmp_path / "r.toml"
    text = """
        [[files]]
        [files.wide.left_1]
        counts = "c1"
        load_n = { column = "kg", unit = "kg", only_where = { foot = "L", cell = "1" } }
        [files.wide.right_1]
        counts = "c1"
        load_n = { column = "kg", unit = "kg", only_where = { foot = "R", cell = "1" } }
    """
    recipe.write_text(f'name = "a"\n{text}')
    table = read_table(log, weights_table(), read_recipe(recipe, {}).reading(log), gravity_mps2=G)
    assert list(table.text("channel")) == ["left_1", "left_1", "right_1", "right_1"]
    assert table.number("counts").tolist() == [3, 9, 77, 88]
    np.testing.assert_allclose(table.number("load_n") / G, [0, 5, 0, 5])
    recipe.write_text(f'name = "a"\n{text}'.replace('foot = "R"', 'foot = "right"'))
    with pytest.raises(DataError, match='no row has foot = "right", cell = "1"'):
        read_table(log, weights_table(), read_recipe(recipe, {}).reading(log), gravity_mps2=G)
