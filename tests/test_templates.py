"""Templates of recipes read the logs that they describe."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from footcal_cli.commands import option_tables
from footcal_cli.recipe import Recipe, read_recipe
from footcal_cli.tables import columns
from footcal_cli.tables.columns import TableType
from footcal_cli.tables.table import read_table

SERIAL = "weight 0 g\nReading: 83\nweight 500 g\nReading: 80\nReading: 81\n"
POINTS = "Punkt;x_soll;y_soll;COPx;COPy\nA;10,5;0;11;0\nB;20;0;21;0,5\n"
TOOL = "0 1 2 3 4 5 6 0 90 0\n0.01 1 2 3 4 5 6 0 90 0\n"


def table_of(said: Recipe) -> str:
    """A log with the columns that a recipe names, counting from 1 in each row."""
    names = [place.column for place in said.columns.values()]
    return "\n".join([",".join(names), *(",".join([str(i + 1)] * len(names)) for i in (0, 1))])


@pytest.mark.parametrize(
    ("name", "text", "column", "expected"),
    [
        ("kitchen_scale_hx711", SERIAL, "load_n", [0.0, 0.5 * 9.80665, 0.5 * 9.80665]),
        ("nao_like_biped", None, "right_rr_counts", [1, 2]),
        ("quadruped_foot_sensors", None, "time_s", [1e-9, 2e-9]),
        ("humanoid_ankle_transducers", None, "left_ty_nm", [1e-3, 2e-3]),
        ("wrist_sensor_tool", TOOL, "body_qy", [0.5**0.5] * 2),
        ("force_plate", POINTS, "cop_y_m", [0.0, 0.5e-3]),
    ],
)
def test_a_template_reads_its_log(
    name: str, text: str | None, column: str, expected: list[float], repository: Path,
    tmp_path: Path,
) -> None:  # fmt: skip
    said = read_recipe(repository / "recipes" / "templates" / f"{name}.toml", option_tables())
    kinds: dict[str, TableType] = {
        "kitchen_scale_hx711": columns.weights_table(),
        "nao_like_biped": columns.cells_table(said.robot.cell_names),
        "quadruped_foot_sensors": columns.cells_table(said.robot.cell_names),
        "humanoid_ankle_transducers": columns.six_axis_feet_table(("left", "right")),
        "wrist_sensor_tool": columns.hang_table(),
        "force_plate": columns.cop_points_table(),
    }
    log = tmp_path / "log.csv"
    log.write_text(text or table_of(said), encoding="utf-8")
    table = read_table(log, kinds[name], said.reading(log), gravity_mps2=9.80665)
    np.testing.assert_allclose(table.number(column), expected, atol=1e-12)
