"""What is left out of a log where a sensor stood at the end of its range."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd

from footcal_cli.recipe import Robot
from footcal_cli.session.saturated import without_saturated
from footcal_cli.tables.table import Table

N = 600


def table_of(**columns: object) -> Table:
    """A log of these columns."""
    return Table(pd.DataFrame(columns), Path("log.csv"), "")


def noise(seed: int) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    return np.random.default_rng(seed).normal(size=N)


def test_a_cut_accelerometer_takes_the_acceleration_of_the_com_with_it() -> None:
    imu = noise(0)
    imu[::50] = 25.0
    body = table_of(
        time_s=np.arange(N) / 100.0,
        com_z_m=0.3 + 0.01 * noise(1),
        **{f"com_acc_{a}_mps2": noise(2 + i) for i, a in enumerate("xyz")},
        **{f"imu_acc_{a}_mps2": imu if a == "z" else noise(5) for a in "xyz"},
    )
    kept, findings = without_saturated(body, Robot())
    lost = np.isnan(kept.number("com_acc_x_mps2"))
    np.testing.assert_array_equal(lost, imu == 25.0)
    assert np.isfinite(kept.number("com_z_m")).all()
    assert [(f.code, f.where) for f in findings] == [("saturated_left_out", "imu_acc_z_mps2")]
    assert findings[0].sentence.startswith("12 of 600 samples")


def test_every_leg_has_ends_of_its_own() -> None:
    wave = 5.0 * np.sin(np.linspace(0.0, 8.0 * np.pi, N)) + 0.01 * noise(3)
    one, other = np.minimum(wave, 4.5), 0.5 * wave
    legs = table_of(
        time_s=np.tile(np.arange(N) / 100.0, 2),
        leg=np.repeat(["fl", "fr"], N),
        fx_n=np.concatenate([one, other]),
        fy_n=np.concatenate([noise(1), noise(2)]),
    )
    kept, findings = without_saturated(legs, Robot())
    np.testing.assert_array_equal(
        np.isnan(kept.number("fx_n")), np.concatenate([wave >= 4.5, np.zeros(N, dtype=bool)])
    )
    assert np.isfinite(kept.number("fy_n")).all()
    assert len(findings) == 1


def test_placements_at_an_end_code_are_rows_that_go_and_weights_are_left_to_the_bench() -> None:
    counts = np.linspace(600.0, 1100.0, N).round().clip(0, 1023)
    robot = Robot.model_validate({"adc": {"bits": 10}})
    rows = table_of(placement=np.repeat("A", N), load_n=np.ones(N), fl_counts=counts)
    kept, (finding,) = without_saturated(rows, robot)
    assert (counts == 1023).sum() / N < 0.2
    assert len(kept) == (counts < 1023).sum()
    assert finding.code == "saturated_left_out"
    weights = table_of(channel=np.repeat("c", N), load_n=np.ones(N), counts=counts)
    assert without_saturated(weights, robot) == (weights, [])
