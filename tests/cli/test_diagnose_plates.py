"""``footcal diagnose`` of placements from the calibration that `offline-fit` made of them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from footcal_cli.core.diagnosis.unnamed import CURVES
from footcal_cli.core.parameters import FloatArray
from footcal_cli.records.diagnosis import DiagnosisRecord
from footcal_cli.records.files import read_record
from footcal_cli.records.results import ParametersRecord
from tests.cli.few_effects import few_or_all
from tests.conftest import Run

CELLS = {"fl": (0.10, 0.045), "fr": (0.10, -0.045), "rl": (-0.08, 0.045), "rr": (-0.08, -0.045)}
WEIGHTS_N, ROUNDS, SCALE = (100.0, 150.0), 3, 0.05


CORNER, STIFF_N_M, GAP_M = np.array([0.105, -0.05]), 8e5, 3e-5
"""Where the plate touches its frame, how stiff its cells are, and from which deflection on."""


def placements(seed: int, share: float, *, touches: bool = False) -> pd.DataFrame:
    """A weight on twelve holes of a plate; the reading of rl holds a share of what fr carries."""
    rng = np.random.default_rng([seed, 21])
    place = np.array(list(CELLS.values()))
    spread = np.linalg.pinv(np.vstack([np.ones(4), place.T]))
    rows = []
    for _ in range(ROUNDS):
        for x in (-0.06, -0.02, 0.03, 0.08):
            for y in (-0.03, 0.0, 0.03):
                for weight in WEIGHTS_N:
                    at = np.array([x, y]) + 2e-4 * rng.standard_normal(2)
                    force = weight * spread @ [1.0, *at]
                    if touches:
                        force = force - beside(force, spread) * spread @ [1.0, *CORNER]
                    shown = force + 0.08 * rng.standard_normal(4)
                    shown[2] += share * force[1]
                    counts = {f"{c}_counts": s / SCALE for c, s in zip(CELLS, shown, strict=True)}
                    rows.append({"foot": "foot", "placement": f"{x},{y}", "hole_x_m": x,
                                 "hole_y_m": y, "load_n": weight, **counts})  # fmt: skip
    return pd.DataFrame(rows)


def beside(force: FloatArray, spread: FloatArray) -> float:
    """What a corner of a rigid plate on four springs carries once it touches, by bisection.

    ``c = 6e5 N/mm^1.4 · (d − gap)^1.4`` with d the deflection there, which the corner itself eases.
    """
    corner = np.array([1.0, *CORNER])
    eased = corner @ spread.T @ spread @ corner / STIFF_N_M
    free = corner @ spread.T @ force / STIFF_N_M - GAP_M
    low, high = 0.0, max(free, 0.0) / eased
    for _ in range(60):
        c = 0.5 * (low + high)
        more = 5.0e7 * max(free - c * eased, 0.0) ** 1.4 > c
        low, high = (c, high) if more else (low, c)
    return low


def weights(seed: int) -> pd.DataFrame:
    rng = np.random.default_rng([seed, 22])
    load = np.tile([0.0, 40.0, 80.0, 120.0, 160.0], 4)
    return pd.concat([
        pd.DataFrame({"channel": f"foot_{cell}", "load_n": load,
                      "session": np.repeat(np.arange(4), 5),
                      "counts": (load + 0.05 * rng.standard_normal(load.size)) / SCALE})
        for cell in CELLS
    ])  # fmt: skip


def calibrated(run: Run, folder: Path, placed: pd.DataFrame) -> tuple[Path, Path]:
    """The recipe and the calibration that `offline-fit` makes of weights and these placements."""
    placed.to_csv(folder / "plate.csv", index=False)
    weights(1).to_csv(folder / "weights.csv", index=False)
    cells = "\n".join(f"{name} = {{ x_m = {x}, y_m = {y} }}" for name, (x, y) in CELLS.items())
    recipe = folder / "r.toml"
    recipe.write_text(
        f"[robot.feet.foot.cells]\n{cells}\n"
        '[data]\nweights = ["weights.csv"]\nplacements = ["plate.csv"]\n', encoding="utf-8",
    )  # fmt: skip
    done = run("offline-fit", "--recipe", recipe, "--no-pictures", "--out", folder / "fit")
    assert done.exit_code == 0, done.err
    return recipe, folder / "fit/parameters.json"


@few_or_all("crosstalk", "cell_position", "load_bypass", "nonlinearity")
@pytest.mark.parametrize("share", [0.04, 0.0])
def test_a_calibration_of_these_placements_hides_nothing_in_them(
    run: Run, tmp_path: Path, few: tuple[str, ...], share: float
) -> None:
    """What `offline-fit` took for crosstalk `diagnose` names, with its size."""
    recipe, given = calibrated(run, tmp_path, placements(1, share))
    done = run("diagnose", "--experiment", "placements", "--recipe", recipe,
               "--parameters", given, "--no-pictures", "--out", tmp_path / "out", *few)  # fmt: skip
    assert done.exit_code == 0, done.err
    record = read_record(DiagnosisRecord, tmp_path / "out/diagnosis.json")
    if not share:
        assert not record.causes, record.sentence
        return
    assert any(e.effect == "crosstalk" for e in read_record(ParametersRecord, given).effects)
    (cause,) = record.causes
    assert (cause.effect, cause.where) == ("crosstalk", "foot_rl")
    assert cause.sd is not None
    assert abs(cause.size - share) < 3.0 * cause.sd


@few_or_all("crosstalk", "cell_position", "load_bypass", "nonlinearity", "hinge", "saturation")
def test_a_corner_that_touches_is_among_the_causes(
    run: Run, tmp_path: Path, few: tuple[str, ...]
) -> None:
    """It bends what the cell there shows as a hinge of that cell would."""
    recipe, given = calibrated(run, tmp_path, placements(2, 0.0, touches=True))
    done = run("diagnose", "--experiment", "placements", "--recipe", recipe,
               "--parameters", given, "--no-pictures", "--out", tmp_path / "out", *few)  # fmt: skip
    assert done.exit_code == 0, done.err
    record = read_record(DiagnosisRecord, tmp_path / "out/diagnosis.json")
    (cause,) = record.causes
    assert (record.verdict, cause.where) == ("ambiguous", "foot_fr")
    (rivals,) = record.rivals
    assert "hinge" in rivals
    assert set(rivals) - CURVES == {"load_bypass"}
    assert "Load bypass in foot_fr acts as" in done.out


def test_stamps_that_begin_again_in_every_file_sort_nothing(run: Run, tmp_path: Path) -> None:
    """Readings of one placement stay together: 72 of them, three outputs each."""
    placed = placements(4, 0.0)
    rows = placed.loc[placed.index.repeat(5)].reset_index(drop=True)
    rows["time_s"] = np.tile(np.arange(5) / 80.0, len(placed))
    recipe, given = calibrated(run, tmp_path, rows)
    done = run("diagnose", "--experiment", "placements", "--recipe", recipe, "--without", "creep",
               "--parameters", given, "--no-pictures", "--out", tmp_path / "out")  # fmt: skip
    assert done.exit_code == 0, done.err
    assert read_record(DiagnosisRecord, tmp_path / "out/diagnosis.json").rows == 3 * len(placed)
