"""What `footcal init` makes of the recordings of others, as their publishers wrote them."""

from __future__ import annotations

import json
import tomllib
from pathlib import Path

import numpy as np
import pytest

from tests.conftest import Run

GUESSES = [
    (
        "forceplate-cop-points/points_frames.csv", "offline-fit", "cop_points",
        {"cop_x_m": "plate_x_m", "hole_y_m": "ref_y_m"},
    ),
    (
        "forceplate-cop-points/points_summary.csv", "offline-fit", "cop_points",
        {"cop_x_m": "plate_x_m_mean", "hole_y_m": "ref_y_m_mean"},
    ),
    (
        "icub-four-ft/trial3_four_ft.csv", "pose-calib", "six_axis_feet",
        {"left_foot_ft_fz_n": "left_foot_ft_fz", "right_leg_ft_tx_nm": "right_leg_ft_tx"},
    ),
    (
        "insole-plenum/calibration_dataset.parquet", "offline-fit", "weights_stream",
        {"load_n": "P0", "cell_114_counts": "taxel114"},
    ),
    ("loadcell-creep/test2.csv", "offline-fit", "weights_stream", {"time_s": "t_s"}),
    (
        "loadsol-insoles/test_poids_loadsol.csv", "static-init", "cells",
        {"left_heel_counts": "l_heel_N", "right_medial_counts": "r_medial_N"},
    ),
    (
        "reemc-walking/14_1.csv", "online-replay", "cells",
        {"left_fx_n": "ftl_fx", "com_z_m": "com_z", "right_foot_qw": "footr_qw"},
    ),
]  # fmt: skip


@pytest.mark.parametrize(
    ("log", "command", "role", "columns"), GUESSES, ids=[log for log, *_ in GUESSES]
)
def test_a_recording_of_others_is_understood(
    log: str, command: str, role: str, columns: dict[str, str], real_data: Path, run: Run,
    tmp_path: Path,
) -> None:  # fmt: skip
    answer = run("init", real_data / log, "-o", tmp_path / "guess.toml")
    assert answer.exit_code == 0, answer.err
    assert f"footcal {command} --recipe" in answer.out
    recipe = tomllib.loads((tmp_path / "guess.toml").read_text(encoding="utf-8"))
    assert set(recipe["data"]) == {role}
    for name, wanted in columns.items():
        place = recipe["columns"][name]
        assert (place if isinstance(place, str) else place["column"]) == wanted
    totals = [name for name in recipe["columns"] if name in ("left_counts", "right_counts")]
    assert not totals, "a foot's total is no cell"


def test_a_plate_is_corrected_by_the_guessed_recipe(
    real_data: Path, run: Run, tmp_path: Path
) -> None:
    log, recipe = real_data / "forceplate-cop-points/points_frames.csv", tmp_path / "guess.toml"
    assert run("init", log, "-o", recipe, "--quiet").exit_code == 0
    answer = run("offline-fit", "--recipe", recipe, "--out", tmp_path / "out", "--no-pictures")
    assert answer.exit_code == 0, answer.err
    assert "No correction of the CoP helps" in answer.out


def test_transducers_in_series_are_compared_by_the_guessed_recipe(
    real_data: Path, run: Run, tmp_path: Path, repository: Path
) -> None:
    """The guess finds the project's pairs and its relative mountings."""
    log, recipe = real_data / "icub-four-ft/trial3_four_ft.csv", tmp_path / "guess.toml"
    assert run("init", log, "-o", recipe).exit_code == 0
    own = repository / "recipes/icub_four_ft.toml"
    found = []
    for out, words in (("guess", ()), ("own", (log,))):
        words = (*words, "--recipe", recipe if out == "guess" else own, "--no-pictures")
        done = run("pose-calib", *words, "--out", tmp_path / out)
        assert done.exit_code == 0, done.err
        rows = json.loads((tmp_path / out / "rmse.json").read_text())["rows"]
        found.append([row["rmse"] for row in rows])
    assert found[0] == pytest.approx(found[1], rel=0.05)


@pytest.mark.parametrize(
    "trial",
    [
        "14_1",
        *(
            pytest.param(trial, marks=pytest.mark.slow)
            for trial in ("14_2", "14_3", "14_4", "16_1", "16_2")
        ),
        "16_4",
    ],
)
def test_the_mounting_of_ankle_transducers_is_found(
    trial: str, real_data: Path, run: Run, tmp_path: Path
) -> None:
    """As the robot's drawing has it; in the eighth trial nothing is said."""
    log, recipe = real_data / f"reemc-walking/{trial}.csv", tmp_path / "guess.toml"
    assert run("init", log, "-o", recipe).exit_code == 0
    feet = tomllib.loads(recipe.read_text(encoding="utf-8"))["robot"]["feet"]
    for side in ("left", "right"):
        assert feet[side]["transducer_rotation_rpy_rad"] == pytest.approx([0, -np.pi / 2, 0])


def test_a_plate_and_insoles_that_share_it_are_no_reference_and_cells(
    real_data: Path, run: Run, tmp_path: Path
) -> None:
    logs = [real_data / f"loadsol-insoles/test_poids_{n}.csv" for n in ("forceplate", "loadsol")]
    answer = run("init", *logs, "-o", tmp_path / "guess.toml")
    assert answer.exit_code == 0, answer.err
    assert "footcal static-init --recipe" in answer.out
    assert "load_n" not in (tmp_path / "guess.toml").read_text(encoding="utf-8")
