"""``footcal diagnose`` of one cell's running recording while weights are put on by hand."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from footcal_cli.intake.cases.weights import at_rest
from footcal_cli.recipe.options import PlateauSettings
from footcal_cli.records.diagnosis import DiagnosisRecord
from footcal_cli.records.files import read_record
from tests.conftest import Run

KG = np.array([0, 1, 3, 5, 3, 1, 0, 1, 3, 5, 3, 1, 0], dtype=np.float64)


def test_samples_while_a_hand_puts_a_weight_on_do_not_count() -> None:
    """Within 0.3 s of each change no cell feels what stands in the log; a press never rests."""
    time_s = np.arange(KG.size * 80) * np.float64(0.1)
    rests = at_rest(time_s, 9.8 * np.repeat(KG, 80), PlateauSettings())
    near = np.abs(np.arange(time_s.size)[:, None] - 80 * np.arange(1, KG.size)).min(axis=1) < 3
    assert not rests[near].any()
    assert rests.mean() > 0.7
    assert at_rest(time_s, 50 * np.sin(time_s), PlateauSettings()).all()


def test_loads_in_the_recipe_and_the_temperature_in_the_log_are_read(
    run: Run, tmp_path: Path
) -> None:
    """A zero that goes by 0.08 N/K, under 13 holds of 13 s whose loads the recipe gives in kg."""
    rng = np.random.default_rng(7)
    time_s = 0.25 * np.arange(KG.size * 52)
    warm = 20 + 8 * np.sin(time_s / 30)
    felt = 9.80665 * np.repeat(KG, 52) + 0.08 * (warm - 20) + 0.01 * rng.normal(size=time_s.size)
    rows = [
        f"{t:.2f},{w:.3f},{2e5 + 3.5e4 * f:.0f}" for t, w, f in zip(time_s, warm, felt, strict=True)
    ]
    names = "time_s,temperature_degc,cell_counts"
    (tmp_path / "log.csv").write_text("\n".join([names, *rows]) + "\n")
    said = ", ".join(f"{kg:g}" for kg in KG)
    (tmp_path / "r.toml").write_text(
        f'[robot]\nchannels = ["cell"]\n[offline_fit.plateaus]\nloads = "{said} kg"\n'
        '[data]\nweights_stream = ["log.csv"]\n'
    )
    answer = run(
        "diagnose", "--recipe", tmp_path / "r.toml", "--experiment", "weights", "--no-pictures",
        "--out", tmp_path / "out",
    )  # fmt: skip
    assert answer.exit_code == 0, answer.err
    (cause,) = read_record(DiagnosisRecord, tmp_path / "out/diagnosis.json").causes
    assert cause.effect == "temperature_bias"
    assert cause.sd is not None
    assert abs(cause.size - 0.08) < 4 * cause.sd
