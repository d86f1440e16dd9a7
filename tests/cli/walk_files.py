"""Walks and stands of `tests.core.walk_data` as the files a logger would have written."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd

from footcal_cli.core.parameters import Status
from footcal_cli.records.files import write_record
from footcal_cli.records.results import CovarianceBlock, ParameterRecord, ParametersRecord
from tests.core.walk_data import CELLS, CELLS_FOOT, CHANNELS, Array, Recording, Standing

FEET = ("left", "right")


def write_recipe(folder: Path, made: Recording | Standing, extra: str = "") -> Path:
    """A recipe whose nameplate is the belief the recording was made with."""
    lines = ['name = "walk"', "[robot]", 'name = "pendulum"', f"mass_kg = {made.mass}"]
    for foot in FEET:
        for cell, (x, y) in zip(CELLS, CELLS_FOOT, strict=True):
            lines += [f"[robot.feet.{foot}.cells.{cell}]", f"x_m = {x}", f"y_m = {y}"]
        lines += [
            f"[robot.feet.{foot}]",
            "outline_m = [[0.09, 0.045], [0.09, -0.045], [-0.07, -0.045], [-0.07, 0.045]]",
        ]
    lines += ["[data]", 'cells = "cells.parquet"', 'body = "body.parquet"', extra]
    path = folder / "recipe.toml"
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


def write_belief(folder: Path, made: Recording | Standing) -> Path:
    """The nameplate as an offline calibration."""
    parameters = {}
    for i, channel in enumerate(CHANNELS):
        for name, value, sd, unit in (
            ("scale", made.scale0[i], abs(0.02 * made.scale0[i]), "N/count"),
            ("bias", made.bias0[i], np.hypot(0.3, 0.02 * made.bias0[i]), "N"),
        ):
            parameters[f"{channel}.{name}"] = ParameterRecord(
                value=float(value), sd=float(sd), unit=unit, status=Status.ESTIMATED
            )
    covariance = []
    for i, channel in enumerate(CHANNELS):
        scale, bias = made.scale0[i], made.bias0[i]
        covariance.append(
            CovarianceBlock(
                names=(f"{channel}.scale", f"{channel}.bias"),
                matrix=(
                    ((0.02 * scale) ** 2, 0.02**2 * scale * bias),
                    (0.02**2 * scale * bias, 0.3**2 + (0.02 * bias) ** 2),
                ),
            )
        )
    record = ParametersRecord(
        command="offline-fit", created="2026-01-01T00:00:00+00:00", robot="pendulum",
        gravity_mps2=9.80665, sign_convention="force = scale * counts + bias", frame="cell",
        expressed_at="cell", parameters=parameters, covariance=tuple(covariance),
    )  # fmt: skip
    path = folder / "belief.json"
    write_record(record, path)
    return path


def _body(
    time: Array, com: Array, acc: Array, rate: Array, feet: Array, yaw: Array
) -> pd.DataFrame:
    columns = {"time_s": time}
    for i, axis in enumerate("xyz"):
        columns[f"com_{axis}_m"] = com[:, i]
        columns[f"com_acc_{axis}_mps2"] = acc[:, i]
    for i, axis in enumerate("xy"):
        columns[f"angmom_rate_{axis}_nm"] = rate[:, i]
    for f, foot in enumerate(FEET):
        columns[f"{foot}_foot_x_m"] = feet[:, f, 0]
        columns[f"{foot}_foot_y_m"] = feet[:, f, 1]
        columns[f"{foot}_foot_z_m"] = np.zeros(len(time))
        columns[f"{foot}_foot_yaw_rad"] = yaw[:, f]
    return pd.DataFrame(columns)


def write_walk(folder: Path, rec: Recording, extra: str = "") -> Path:
    """Cells, body, truth and recipe of a walk; returns the recipe."""
    cells = pd.DataFrame(dict(zip((f"{c}_counts" for c in CHANNELS), rec.counts.T, strict=True)))
    cells.insert(0, "time_s", rec.cell_time)
    cells.to_parquet(folder / "cells.parquet", index=False)
    _body(rec.body_time, rec.com, rec.acc, rec.angmom_rate, rec.feet, rec.yaw).to_parquet(
        folder / "body.parquet", index=False
    )
    truth = pd.DataFrame(dict(zip((f"{c}_n" for c in CHANNELS), rec.force.T, strict=True)))
    truth.insert(0, "time_s", rec.cell_time)
    truth.to_parquet(folder / "truth.parquet", index=False)
    return write_recipe(folder, rec, 'truth = "truth.parquet"\n' + extra)


def write_stand(folder: Path, made: Standing, extra: str = "") -> Path:
    """Cells, body and recipe of a stand; returns the recipe."""
    cells = pd.DataFrame(dict(zip((f"{c}_counts" for c in CHANNELS), made.counts.T, strict=True)))
    cells.insert(0, "time_s", made.time)
    cells.to_parquet(folder / "cells.parquet", index=False)
    n = len(made.time)
    first = made.cells[:, [0, 4]]
    feet = np.zeros((n, 2, 2))
    for f in range(2):
        cos, sin = np.cos(made.yaw[:, f]), np.sin(made.yaw[:, f])
        x, y = CELLS_FOOT[0]
        feet[:, f] = first[:, f] - np.stack([cos * x - sin * y, sin * x + cos * y], axis=1)
    zero = np.zeros
    _body(made.time, made.com, zero((n, 3)), zero((n, 2)), feet, made.yaw).to_parquet(
        folder / "body.parquet", index=False
    )
    return write_recipe(folder, made, extra)
