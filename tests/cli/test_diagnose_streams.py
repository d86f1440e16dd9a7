"""``footcal diagnose`` of one cell's running recording while weights are put on by hand."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from footcal_cli.core.parameters import FloatArray
from footcal_cli.intake.cases.weights import at_rest
from footcal_cli.recipe.options import PlateauSettings
from footcal_cli.records.diagnosis import DiagnosisRecord
from footcal_cli.records.files import read_record
from tests.conftest import Answer, Run

KG = np.array([0, 1, 3, 5, 3, 1, 0, 1, 3, 5, 3, 1, 0], dtype=np.float64)


def test_samples_while_a_hand_puts_a_weight_on_do_not_count() -> None:
    """Within 0.3 s of each change no cell feels what stands in the log; a press never rests."""
    time_s = np.arange(KG.size * 80) * np.float64(0.1)
    load = 9.8 * np.repeat(KG, 80)
    rests = at_rest(time_s, load, 2e5 + 3.5e4 * load, PlateauSettings())
    near = np.abs(np.arange(time_s.size)[:, None] - 80 * np.arange(1, KG.size)).min(axis=1) < 3
    assert not rests[near].any()
    assert rests.mean() > 0.7
    press = 50 * np.sin(time_s)
    assert at_rest(time_s, press, 2e5 + 3.5e4 * press, PlateauSettings()).all()


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


ROWS = 52
"""Of a hold, at 4 Hz."""
AT_S = 0.25 * np.arange(KG.size * ROWS)


def diagnosed(run: Run, folder: Path, written_kg: FloatArray, zero_n: FloatArray) -> Answer:
    """A log with its loads, of a cell whose zero moves."""
    rng = np.random.default_rng(8)
    felt = 9.80665 * np.repeat(KG, ROWS) + zero_n + 0.01 * rng.normal(size=AT_S.size)
    rows = [
        f"{t:.2f},{kg:g},{2e5 + 3.5e4 * f:.0f}"
        for t, kg, f in zip(AT_S, np.repeat(written_kg, ROWS), felt, strict=True)
    ]
    (folder / "log.csv").write_text("\n".join(["time_s,load_kg,cell_counts", *rows]) + "\n")
    (folder / "r.toml").write_text(
        '[robot]\nchannels = ["cell"]\n[columns]\nload_n = { column = "load_kg", unit = "kg" }\n'
        '[data]\nweights_stream = ["log.csv"]\n'
    )
    return run(
        "diagnose", "--recipe", folder / "r.toml", "--experiment", "weights", "--no-pictures",
        "--out", folder / "out",
    )  # fmt: skip


@pytest.mark.parametrize(
    ("zero_n", "effect", "size_n"),
    [
        (1.5 * (0.61 * AT_S[-1] <= AT_S), "bias_jump", 1.5),
        (-2.0 * np.exp(-AT_S / 40.0), "bias_drift", 2.0 / 1800.0),
    ],
    ids=["jump", "warm_up"],
)
def test_a_zero_that_moves_once_is_named(
    run: Run, tmp_path: Path, zero_n: FloatArray, effect: str, size_n: float
) -> None:
    """No block repeats the jump; the loads before it and after it are evidence of each other."""
    answer = diagnosed(run, tmp_path, KG, zero_n)
    assert answer.exit_code == 0, answer.err
    record = read_record(DiagnosisRecord, tmp_path / "out/diagnosis.json")
    assert record.verdict == "named"
    (cause,) = record.causes
    assert cause.effect == effect
    assert cause.ci95 is not None
    assert cause.ci95[0] <= size_n <= cause.ci95[1]


def test_a_weight_with_another_one_s_label_stops_the_diagnosis(run: Run, tmp_path: Path) -> None:
    written = KG.copy()
    written[7] = 5.0
    answer = diagnosed(run, tmp_path, written, np.zeros(AT_S.size))
    assert "is written as 49.033 N" in answer.out + answer.err
    assert "reads what it reads at 9.8066 N" in answer.out + answer.err
    record = read_record(DiagnosisRecord, tmp_path / "out/diagnosis.json")
    assert record.verdict == "bad-data"


def test_two_recordings_of_a_cell_are_one_case(run: Run, tmp_path: Path) -> None:
    """Each ladder in a file of its own; the second cell creeps, and the first does not."""
    rng = np.random.default_rng(11)
    load, tau_s, share = 9.80665 * np.repeat(KG, ROWS), 30.0, 0.02
    crept, late = np.zeros(load.size), 0.0
    for i, force in enumerate(load):
        crept[i] = late
        late += (force - late) * 0.25 / tau_s
    for number in (1, 2):
        noise = 0.01 * rng.normal(size=(load.size, 2))
        felt = np.column_stack([load, load + share * crept]) + noise
        rows = [
            f"{t:.2f},{force / 9.80665:g},{2e5 + 3.5e4 * a:.0f},{1e5 + 3.1e4 * b:.0f}"
            for t, force, (a, b) in zip(AT_S, load, felt, strict=True)
        ]
        names = "time_s,load_kg,toe_counts,heel_counts"
        (tmp_path / f"run{number}.csv").write_text("\n".join([names, *rows]) + "\n")
    (tmp_path / "r.toml").write_text(
        '[robot]\nchannels = ["toe", "heel"]\n'
        '[columns]\nload_n = { column = "load_kg", unit = "kg" }\n'
        '[data]\nweights_stream = ["run1.csv", "run2.csv"]\n'
    )
    answer = run(
        "diagnose", "--recipe", tmp_path / "r.toml", "--experiment", "weights", "--no-pictures",
        "--out", tmp_path / "out",
    )  # fmt: skip
    assert answer.exit_code == 0, answer.err
    record = read_record(DiagnosisRecord, tmp_path / "out/diagnosis.json")
    (cause,) = record.causes
    assert (cause.effect, cause.where) == ("creep", "heel")
    assert cause.size == pytest.approx(share, rel=0.02)  # steps of 0.25 s here, exact there
