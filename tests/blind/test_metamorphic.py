"""What must not change a diagnosis: units, order of rows, names, calibration, copies of rows."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from tests.blind.diagnosing import diagnosed
from tests.blind.plan import Cell
from tests.blind.trials import make_trial

SEED = 49
"""Two cells and few rows: seconds per diagnosis."""
FAMILIES, PERMUTATIONS = 3, 1999
"""Of tests in this trial, and of the blocks in the coarsest of them."""
Change = Callable[[pd.DataFrame], pd.DataFrame]


@pytest.fixture(scope="module")
def trial(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Weights with two hidden effects, one of them small."""
    folder = tmp_path_factory.mktemp("metamorphic") / "trial"
    make_trial(Cell("pair", "weights", ("hysteresis/bouc_wen", "creep/table"), 0.6), SEED, folder)
    ask = {"experiment": "weights", "left_out": ""}
    (folder / "ask.json").write_text(json.dumps(ask), encoding="utf-8")
    return folder


@pytest.fixture(scope="module")
def before(trial: Path) -> dict[str, Any]:
    return diagnosed(trial, trial.parent / "run")


def _changed(trial: Path, folder: Path, change: Change, recipe: str = "") -> dict[str, Any]:
    folder.mkdir()
    log = next(p for p in trial.iterdir() if p.stem == "weights")
    frame = pd.read_parquet(log) if log.suffix == ".parquet" else pd.read_csv(log)
    change(frame).to_csv(folder / "weights.csv", index=False, float_format="%.17g")
    text = (trial / "recipe.toml").read_text(encoding="utf-8").replace(log.name, "weights.csv")
    (folder / "recipe.toml").write_text(text + recipe, encoding="utf-8")
    (folder / "ask.json").write_text((trial / "ask.json").read_text(encoding="utf-8"))
    return diagnosed(folder, folder / "run")


def _p_values(record: dict[str, Any]) -> dict[str, float]:
    """Of every effect that was tested."""
    return {r["effect"]: r["p"] for r in record["effects"] if r["p"] is not None}


def _to_the_digit(p: float) -> float:
    return 1e-9


def _to_the_draws(p: float) -> float:
    """Four sd of the difference of two p-values, each from sign patterns of its own.

    A family's p is the number of families times a share of the draws.
    """
    share = p / FAMILIES
    return 1e-9 + 4.0 * FAMILIES * float(np.sqrt(2.0 * share * (1.0 - share) / PERMUTATIONS))


def _to_rounding(p: float) -> float:
    """Another converter rounds the readings anew, which is noise."""
    return 2e-3 + 0.2 * float(np.sqrt(min(p, 1.0 - p)))


def _same(
    record: dict[str, Any],
    before: dict[str, Any],
    allowed: Callable[[float], float] = _to_the_digit,
) -> None:
    """The same answer, p-values as near as allowed."""
    assert record["verdict"] == before["verdict"]
    assert [c["effect"] for c in record["causes"]] == [c["effect"] for c in before["causes"]]
    for effect, p in _p_values(before).items():
        assert _p_values(record)[effect] == pytest.approx(p, abs=allowed(p)), effect
    for mine, other in zip(record["causes"], before["causes"], strict=True):
        assert mine["size"] == pytest.approx(other["size"], rel=1e-2)


def test_something_was_found_at_all(before: dict[str, Any]) -> None:
    assert before["verdict"] in ("named", "ambiguous", "named+unknown")


@pytest.mark.slow
def test_a_calibration_direction_in_the_data_changes_no_p_value(
    trial: Path, before: dict[str, Any], tmp_path: Path
) -> None:
    """Other scales and zeros of the converter are what calibration is for."""

    def other_converter(frame: pd.DataFrame) -> pd.DataFrame:
        code = frame["channel"].astype("category").cat.codes.to_numpy()
        scale, shift = np.array([1.1, 0.8, 1.3, 0.95])[code], np.array([2e5, -1e5, 0, 5e4])[code]
        return frame.assign(counts=frame["counts"] * scale + shift)

    _same(_changed(trial, tmp_path / "calibrated", other_converter), before, _to_rounding)


def test_order_of_rows_changes_nothing(trial: Path, before: dict[str, Any], tmp_path: Path) -> None:
    # channels come in another order, so random sign patterns fall on other blocks
    shuffled = _changed(trial, tmp_path / "shuffled", lambda f: f.sample(frac=1, random_state=3))
    _same(shuffled, before, _to_the_draws)


def test_units_change_nothing(trial: Path, before: dict[str, Any], tmp_path: Path) -> None:
    """Loads in kilograms-force under a foreign name."""

    def in_kgf(frame: pd.DataFrame) -> pd.DataFrame:
        return frame.assign(Weight=frame["load_n"] / 9.80665).drop(columns="load_n")

    recipe = '\n[columns]\nload_n = { column = "Weight", unit = "kgf" }\n'
    _same(_changed(trial, tmp_path / "kgf", in_kgf, recipe), before)


def test_names_of_cells_change_nothing(trial: Path, before: dict[str, Any], tmp_path: Path) -> None:
    names = {"left_fl": "left_a", "left_fr": "left_b", "left_rl": "left_c", "left_rr": "left_d"}

    def renamed(frame: pd.DataFrame) -> pd.DataFrame:
        return frame.assign(channel=frame["channel"].map(names))

    folder = tmp_path / "renamed"
    recipe = trial / "recipe.toml"
    original = recipe.read_text(encoding="utf-8")
    text = original
    for old, new in names.items():
        text = text.replace(old, new)
    try:
        recipe.write_text(text, encoding="utf-8")
        record = _changed(trial, folder, renamed)
    finally:
        recipe.write_text(original, encoding="utf-8")
    _same(record, before)


def test_copies_of_rows_are_no_evidence(
    trial: Path, before: dict[str, Any], tmp_path: Path
) -> None:
    """Every row twice: nothing else gets a name, and no p-value gets smaller by it."""
    record = _changed(trial, tmp_path / "twice", lambda f: f.loc[np.repeat(f.index, 2)])
    given = {c["effect"] for c in before["causes"]} | set().union(*before["rivals"], set())
    assert {c["effect"] for c in record["causes"]} <= given
    was = _p_values(before)
    for effect, p in _p_values(record).items():
        assert p >= 0.3 * was[effect] - 1e-3, effect
