"""Failure modes of the foot paper's section 5.1, one simulated walk each, and their diagnosis."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from footcal_cli.records.diagnosis import DiagnosisRecord
from footcal_cli.records.files import read_record
from tests.papers.commands import run
from tests.papers.formats import Rows

ROOT = Path(__file__).resolve().parents[2]
RECIPE = ROOT / "recipes" / "nao_simulated.toml"


@dataclass(frozen=True)
class Mode:
    """A failure mode as it is put into a walk.

    Parameters
    ----------
    mode, shown
        The paper's words; what is in the log.
    effects
        As ``simulate --effect`` takes them.
    body
        What is done to the body's stream besides, None for nothing.
    """

    mode: str
    shown: str
    effects: tuple[str, ...] = ()
    body: Callable[[pd.DataFrame], pd.DataFrame] | None = None


def impacts(body: pd.DataFrame) -> pd.DataFrame:
    """Spikes of the vertical acceleration where a foot lands, clipped as a 2 g sensor clips."""
    shaken = body.copy()
    left, right = (body[f"{foot}_foot_x_m"].to_numpy(dtype=float) for foot in ("left", "right"))
    moving = np.hypot(np.diff(left), np.diff(right))
    landing = np.flatnonzero((moving[:-1] > 1e-4) & ~(moving[1:] > 1e-4)) + 2
    spike = np.array([40.0, -30.0, 15.0])
    values = shaken["com_acc_z_mps2"].to_numpy(dtype=float).copy()
    for at in landing[landing < len(values) - spike.size]:
        values[at : at + spike.size] += spike
    shaken["com_acc_z_mps2"] = np.clip(values, -19.6, 19.6)
    return shaken


MODES = (
    Mode("none", "a clean walk"),
    Mode("compliance", "`hysteresis` 0.8 N in one cell", ("left_rr.hysteresis=0.8",)),
    Mode("compliance", "`creep` 5 % in one cell", ("left_rr.creep=0.05",)),
    Mode("compliance", "`load_bypass` 5 % of the left foot", ("left.load_bypass=0.05",)),
    Mode("slip", "`slip` of the left foot by 10 mm", ("left.slip=0.01,slip_y=0.005",)),
    Mode("partial contact", "`cell_position`: one cell bears 5 mm inward",
         ("left_fl.cell_position=-0.005",)),
    Mode("impacts, saturated IMU", "spikes of 40 m/s² at landings, clipped at 2 g", (), impacts),
    Mode("IMU bias", "`accel_bias` 0.2 m/s² ahead", ("accel_bias=0.2",)),
    Mode("IMU misalignment", "`imu_tilt` 2°", ("imu_tilt=0.035",)),
    Mode("synchronisation", "`delay` 15 ms more than compensated", ("delay=0.015",)),
    Mode("synchronisation", "`clock_drift` 400 ppm", ("clock_drift=0.0004",)),
)  # fmt: skip


def run_modes(out: Path) -> Rows:
    """Simulate and diagnose each mode; rows of the page's table."""
    rows = []
    for number, mode in enumerate(MODES):
        folder = out / "modes" / str(number)
        asked = [word for effect in mode.effects for word in ("--effect", effect)]
        made = run("simulate", "--experiment", "walk", "--seed", str(60 + number), "--no-pictures",
                   *asked, out=folder / "log")  # fmt: skip
        body = made / "body.parquet"
        if mode.body is not None:
            body = folder / "body.parquet"
            mode.body(pd.read_parquet(made / "body.parquet")).to_parquet(body)
        found = run("diagnose", made / "cells.parquet", body, "--experiment", "walk", "--recipe",
                    RECIPE, "--no-pictures", out=folder / "diagnosis")  # fmt: skip
        record = read_record(DiagnosisRecord, found / "diagnosis.json")
        rows.append((mode.mode, mode.shown, record.verdict, record.sentence.split(". ")[0]))
    return rows
