"""The committed logs of the physics biped: the truth beside them explains them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from footcal_cli.core.centroidal import dynamic_reference
from footcal_cli.core.simulation.biped_logs import cell_positions
from footcal_cli.core.simulation.robots import Biped
from footcal_cli.records.files import read_record
from footcal_cli.records.results import TruthRecord

ROBOT = Biped()
LOGS = ("stand", "walk_002", "walk_004", "walk_010", "walk_004_faulty")


@pytest.mark.parametrize("log", LOGS)
def test_counts_are_the_loads_through_the_true_calibration(repository: Path, log: str) -> None:
    folder = repository / "sample_data/biped"
    truth = read_record(TruthRecord, folder / f"{log}_truth.json")
    cells = pd.read_parquet(folder / f"{log}_cells.parquet")
    loads = pd.read_parquet(folder / f"{log}_true_loads.parquet")
    for channel in ROBOT.channels:
        scale, bias = (truth.parameters[f"{channel}.{name}"] for name in ("scale", "bias"))
        error = scale * cells[f"{channel}_counts"] + bias - loads[f"{channel}_n"]
        faulty = f"{channel}.hysteresis_width" in truth.parameters
        assert error.std() > 0.15 if faulty else error.std() < 0.06, channel
        assert abs(error.mean()) < (0.5 if faulty else 0.1), channel


@pytest.mark.parametrize("log", ["walk_002", "walk_004", "walk_010"])
def test_pad_forces_obey_newton_and_euler(repository: Path, log: str) -> None:
    """Against the body's own noisy stream, 20 ms late: 0.5 % of body weight and 2 mm."""
    folder = repository / "sample_data/biped"
    body = pd.read_parquet(folder / f"{log}_body.parquet").astype(float)
    table = pd.read_parquet(folder / f"{log}_true_loads.parquet").astype(float)
    loads = table[[f"{channel}_n" for channel in ROBOT.channels]].to_numpy()
    at = table["time_s"].to_numpy()
    taken = body["time_s"].to_numpy() - 0.020

    def stream(*names: str) -> np.ndarray:
        return np.stack([np.interp(at, taken, body[name]) for name in names], axis=-1)

    reference = dynamic_reference(
        stream("com_x_m", "com_y_m", "com_z_m"),
        stream("com_acc_x_mps2", "com_acc_y_mps2", "com_acc_z_mps2"),
        stream("angmom_rate_x_nm", "angmom_rate_y_nm"),
        np.full(len(at), ROBOT.mass_kg),
        np.full(len(at), ROBOT.gravity_mps2),
    )
    feet = np.stack([stream(*(f"{f}_foot_{a}_m" for a in "xyz")) for f in ROBOT.feet], axis=1)
    yaw = stream(*(f"{foot}_foot_yaw_rad" for foot in ROBOT.feet))
    places = cell_positions(ROBOT, feet, yaw)
    fz = loads.sum(axis=1)
    cop = np.einsum("nc,nci->ni", loads, places) / fz[:, None]
    on = np.stack([loads[:, :4].sum(axis=1), loads[:, 4:].sum(axis=1)], axis=-1) > 0.5
    alone = on.sum(axis=1) == 1
    settled = alone & np.roll(alone, 8) & np.roll(alone, -8)
    assert settled.mean() > 0.2
    off = (fz - reference.fz_n)[settled]
    missed = (cop - reference.cop_m)[settled]
    assert np.sqrt(np.mean(off**2)) < 0.005 * ROBOT.weight_n
    assert np.sqrt(np.mean(np.sum(missed**2, axis=1))) < 2e-3
