"""``footcal diagnose`` of a tool on a wrist, held in measured attitudes, as the shell runs it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from scipy.spatial.transform import Rotation

from footcal_cli.records.diagnosis import DiagnosisRecord
from footcal_cli.records.files import read_record
from tests.conftest import Run

HOLDS, ROWS, STEP_S, WEIGHT_N = 12, 10, 0.4, 20.0
COM_M, OFFSET = np.array([0.012, -0.004, 0.07]), np.array([3.0, -6.0, 8.0, 0.1, -0.2, 0.05])
RECIPE = """
[columns]
leg = { value = "wrist" }
"""
JUMP_AT = 7
HIDDEN = {
    "drift": ("offset_drift", "offset_drift_fz", 3.0 / (HOLDS * ROWS * STEP_S)),
    "jump": ("offset_change", "offset_change_fy", 1.5),
    "gain": ("scale_matrix", "gain_fx", 0.02),
}
COUPLING = 0.026
GAINS = np.array([0.004, -0.003, 0.004, -0.01, 0.003, -0.004])
"""What the force along x adds to that along z; and ordinary gains, of which one axis stands out."""


def write_wrist(
    path: Path, hidden: str, holds: int = HOLDS, rows: int = ROWS, sd: float = 0.03
) -> None:
    """Random attitudes of a sensor mounted 1° askew on an arm whose base leans by 1°."""
    rng = np.random.default_rng([5, len(hidden)])
    mount, base = Rotation.from_rotvec([0.012, -0.01, 0.02]), np.array([0.015, 0.01, -1.0])
    frames = []
    for k, turn in enumerate(Rotation.random(holds, random_state=rng)):
        force = mount.inv().apply(turn.inv().apply(WEIGHT_N * base / np.linalg.norm(base)))
        time_s = (k * rows + np.arange(rows)) * STEP_S
        wrench = np.tile(np.concatenate([force, np.cross(COM_M, force)]), (rows, 1))
        wrench[:, 0] *= 1.02 if hidden == "gain" else 1.0
        wrench[:, 1] += 1.5 * (hidden == "jump" and k >= JUMP_AT)
        wrench[:, 2] += (hidden == "drift") * HIDDEN["drift"][2] * time_s
        if hidden == "coupling":
            wrench[:, 2] += COUPLING * wrench[:, 0]
            wrench *= 1.0 + GAINS
        wrench += OFFSET + rng.normal(0.0, sd, (rows, 6)) * [1, 1, 1, 0.05, 0.05, 0.05]
        row = np.column_stack([time_s, np.tile(turn.as_quat(), (rows, 1)), wrench])
        frames.append(row)
    names = ["time_s", *(f"body_q{a}" for a in "xyzw"), "fx_n", "fy_n", "fz_n"]
    table = pd.DataFrame(np.vstack(frames), columns=[*names, "tx_nm", "ty_nm", "tz_nm"])
    table.to_csv(path, index=False)


def diagnosed(folder: Path, run: Run) -> DiagnosisRecord:
    """What `diagnose` says of the log in a folder."""
    (folder / "wrist.toml").write_text(RECIPE)
    out = folder / "out"
    done = run(
        "diagnose", str(folder / "wrist.csv"), "--experiment", "hang",
        "--recipe", str(folder / "wrist.toml"), "--out", str(out),
    )  # fmt: skip
    assert done.exit_code == 0, done.err
    return read_record(DiagnosisRecord, out / "diagnosis.json")


@pytest.mark.parametrize(
    "hidden", [pytest.param(h, marks=[pytest.mark.slow] if h == "drift" else []) for h in HIDDEN]
)
def test_what_is_wrong_with_a_wrist_sensor_is_named(tmp_path: Path, run: Run, hidden: str) -> None:
    write_wrist(tmp_path / "wrist.csv", hidden)
    record = diagnosed(tmp_path, run)
    effect, parameter, size = HIDDEN[hidden]
    assert record.verdict == "named", record.sentence
    (cause,) = record.causes
    assert (cause.effect, cause.parameter) == (effect, parameter)
    assert cause.sd is not None
    assert abs(cause.size - size) < 4.0 * cause.sd
    assert cause.sd < 0.05 * size


def test_gains_too_small_to_matter_hide_no_coupling(tmp_path: Path, run: Run) -> None:
    """The gain of a torque is surer than the coupling, and changes nothing that matters."""
    write_wrist(tmp_path / "wrist.csv", "coupling", holds=44, rows=1, sd=0.05)
    record = diagnosed(tmp_path, run)
    assert record.verdict == "named", record.sentence
    (cause,) = record.causes
    assert (cause.effect, cause.parameter) == ("cross_coupling", "coupling_fz_fx")
    assert cause.sd is not None
    assert abs(cause.size - COUPLING) < 4.0 * cause.sd
    assert cause.sd < 0.1 * COUPLING


@pytest.mark.parametrize("hidden", ["gain", ""])
def test_one_row_per_attitude_is_enough(tmp_path: Path, run: Run, hidden: str) -> None:
    """Means over seconds: a row does not tell its own zero from its load, and need not."""
    write_wrist(tmp_path / "wrist.csv", hidden, holds=40, rows=1, sd=0.01)
    record = diagnosed(tmp_path, run)
    named = [(c.effect, c.parameter) for c in record.causes]
    assert named == ([HIDDEN[hidden][:2]] if hidden else []), record.sentence
