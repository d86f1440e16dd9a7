"""``footcal diagnose`` of placements from the calibration that `offline-fit` made of them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from footcal_cli.records.diagnosis import DiagnosisRecord
from footcal_cli.records.files import read_record
from footcal_cli.records.results import ParametersRecord
from tests.cli.few_effects import few_or_all
from tests.conftest import Run

CELLS = {"fl": (0.10, 0.045), "fr": (0.10, -0.045), "rl": (-0.08, 0.045), "rr": (-0.08, -0.045)}
WEIGHTS_N, ROUNDS, SCALE = (100.0, 150.0), 3, 0.05


def placements(seed: int, share: float) -> pd.DataFrame:
    """A weight on twelve holes of a plate; the reading of rl holds a share of what fr carries."""
    rng = np.random.default_rng([seed, 21])
    place = np.array(list(CELLS.values()))
    rows = []
    for _ in range(ROUNDS):
        for x in (-0.06, -0.02, 0.03, 0.08):
            for y in (-0.03, 0.0, 0.03):
                for weight in WEIGHTS_N:
                    at = np.array([x, y]) + 2e-4 * rng.standard_normal(2)
                    force = weight * np.linalg.pinv(np.vstack([np.ones(4), place.T])) @ [1.0, *at]
                    shown = force + 0.08 * rng.standard_normal(4)
                    shown[2] += share * force[1]
                    counts = {f"{c}_counts": s / SCALE for c, s in zip(CELLS, shown, strict=True)}
                    rows.append({"foot": "foot", "placement": f"{x},{y}", "hole_x_m": x,
                                 "hole_y_m": y, "load_n": weight, **counts})  # fmt: skip
    return pd.DataFrame(rows)


def weights(seed: int) -> pd.DataFrame:
    rng = np.random.default_rng([seed, 22])
    load = np.tile([0.0, 40.0, 80.0, 120.0, 160.0], 4)
    return pd.concat([
        pd.DataFrame({"channel": f"foot_{cell}", "load_n": load,
                      "session": np.repeat(np.arange(4), 5),
                      "counts": (load + 0.05 * rng.standard_normal(load.size)) / SCALE})
        for cell in CELLS
    ])  # fmt: skip


@few_or_all("crosstalk", "cell_position", "load_bypass", "nonlinearity")
@pytest.mark.parametrize("share", [0.04, 0.0])
def test_a_calibration_of_these_placements_hides_nothing_in_them(
    run: Run, tmp_path: Path, few: tuple[str, ...], share: float
) -> None:
    """What `offline-fit` took for crosstalk `diagnose` names, with its size."""
    placements(1, share).to_csv(tmp_path / "plate.csv", index=False)
    weights(1).to_csv(tmp_path / "weights.csv", index=False)
    cells = "\n".join(f"{name} = {{ x_m = {x}, y_m = {y} }}" for name, (x, y) in CELLS.items())
    (tmp_path / "r.toml").write_text(
        f"[robot.feet.foot.cells]\n{cells}\n"
        '[data]\nweights = ["weights.csv"]\nplacements = ["plate.csv"]\n', encoding="utf-8",
    )  # fmt: skip
    done = run("offline-fit", "--recipe", tmp_path / "r.toml", "--no-pictures",
               "--out", tmp_path / "fit")  # fmt: skip
    assert done.exit_code == 0, done.err
    given = tmp_path / "fit/parameters.json"
    done = run("diagnose", "--experiment", "placements", "--recipe", tmp_path / "r.toml",
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
