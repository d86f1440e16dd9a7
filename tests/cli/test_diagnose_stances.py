"""``footcal diagnose`` of a robot that steps from one quiet stance to the next in one recording."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from footcal_cli.core.parameters import FloatArray
from footcal_cli.records.diagnosis import DiagnosisRecord
from footcal_cli.records.files import read_record
from tests.conftest import Run

CELLS = {"fl": (0.10, 0.045), "fr": (0.10, -0.045), "rl": (-0.08, 0.045), "rr": (-0.08, -0.045)}
FEET_Y = {"left": 0.11, "right": -0.11}
STANCES, HOLD_S, MOVE_S, RATE_HZ, MASS_KG, HEIGHT_M = 16, 6.0, 0.5, 20.0, 30.0, 0.62
GRAVITY = 9.80665


def recipe() -> str:
    """Cells in N, known to a hundredth and a newton."""
    cells = "\n".join(f"{name} = {{ x_m = {x}, y_m = {y} }}" for name, (x, y) in CELLS.items())
    columns = [f'{foot}_{cell}_counts = "{foot}_{cell}"' for foot in FEET_Y for cell in CELLS]
    feet = "\n".join(f"[robot.feet.{foot}.cells]\n{cells}" for foot in FEET_Y)
    return (
        f'[robot]\nname = "walker"\nmass_kg = {MASS_KG}\n'
        "[robot.nameplate]\nscale_n_per_count = 1.0\nzero_counts = 0\n"
        f"scale_relative_sd = 0.01\nbias_sd_n = 1.0\n{feet}\n[columns]\n" + "\n".join(columns)
    )


def stand(seed: int, play_n: float) -> pd.DataFrame:
    """Both feet on the ground; the body steps to a new place every six seconds.

    Parameters
    ----------
    play_n
        Half width of a play in the left front cell, which reads three newtons more or less by the
        way that the load went last; 0 for none.
    """
    rng = np.random.default_rng([seed, 9])
    time_s = np.arange(0.0, STANCES * HOLD_S, 1.0 / RATE_HZ)
    stance = (time_s // HOLD_S).astype(int)
    ease = np.clip((time_s - stance * HOLD_S) / MOVE_S, 0.0, 1.0)
    ease = ease**2 * (3.0 - 2.0 * ease)
    com: dict[str, FloatArray] = {}
    acc: dict[str, FloatArray] = {}
    for axis, reach in (("x", 0.05), ("y", 0.05)):
        to = rng.uniform(-reach, reach, STANCES)
        com[axis] = to[np.maximum(stance - 1, 0)] * (1.0 - ease) + to[stance] * ease
        acc[axis] = np.gradient(np.gradient(com[axis], time_s), time_s)
    cop = {axis: com[axis] - HEIGHT_M / GRAVITY * acc[axis] for axis in com}
    left = np.clip(0.5 + cop["y"] / 0.22, 0.0, 1.0)
    place = np.array(list(CELLS.values()))
    share = np.linalg.pinv(np.vstack([np.ones(4), place.T]))
    log = {"time_s": time_s}
    for foot, part in (("left", left), ("right", 1.0 - left)):
        load = MASS_KG * GRAVITY * part
        force = (share @ np.stack([load, load * cop["x"], 0.0 * load])).T
        if foot == "left" and play_n > 0.0:
            state = 0.0
            for i, step in enumerate(np.diff(force[:, 0], prepend=force[0, 0])):
                state = float(np.clip(state + step / play_n, -1.0, 1.0))
                force[i, 0] += 3.0 * state
        gain, bias = 1.0 + rng.normal(0.0, 0.01, 4), rng.normal(0.0, 1.0, 4)
        reading = (force - bias) / gain + rng.normal(0.0, 0.15, force.shape)
        log |= {f"{foot}_{cell}": reading[:, k] for k, cell in enumerate(CELLS)}
        still = np.zeros(time_s.size)
        log |= {f"{foot}_foot_{axis}_m": still for axis in "xz"}
        log |= {f"{foot}_foot_y_m": still + FEET_Y[foot], f"{foot}_foot_yaw_rad": still}
    com["z"], acc["z"] = np.full(time_s.size, HEIGHT_M), np.zeros(time_s.size)
    for axis in "xyz":
        log[f"com_{axis}_m"] = com[axis] + rng.normal(0.0, 3e-4, time_s.size)
        log[f"com_acc_{axis}_mps2"] = acc[axis] + rng.normal(0.0, 0.02, time_s.size)
    return pd.DataFrame(log)


@pytest.mark.parametrize(
    ("play_n", "quiet"), [(0.0, True), pytest.param(15.0, False, marks=pytest.mark.slow)]
)
def test_a_weight_that_differs_from_stance_to_stance_is_no_noise(
    tmp_path: Path, run: Run, play_n: float, quiet: bool
) -> None:
    log, made, out = tmp_path / "stand.csv", tmp_path / "r.toml", tmp_path / "out"
    stand(3, play_n).to_csv(log, index=False, float_format="%.6g")
    made.write_text(recipe(), encoding="utf-8")
    done = run("diagnose", log, log, "--experiment", "stand", "--recipe", made, "--no-pictures",
               "--out", out)  # fmt: skip
    assert done.exit_code == 0, done.err
    record = read_record(DiagnosisRecord, out / "diagnosis.json")
    assert (record.verdict == "none") is quiet, record.sentence
    assert quiet or not record.causes or record.causes[0].effect == "hysteresis"
