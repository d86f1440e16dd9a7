"""``footcal diagnose`` of a bench of two sessions per cell, and of stacks of named pieces."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from footcal_cli.records.diagnosis import DiagnosisRecord
from footcal_cli.records.files import read_record
from tests.cli.few_effects import few_or_all
from tests.conftest import Run

CELLS, LARGEST_N, HOLD_S, RATE_HZ = 4, 200.0, 30.0, 2.0
PIECES = {"W1": 5.0, "W2": 5.0, "W3": 5.0, "W4": 10.0, "W5": 10.0}
STACKS = ("none", "W1", "W1+W2", "W3", "W1+W4", "W3+W4", "W4+W5", "W1+W2+W3", "W3+W4+W5", "none")
GRAVITY = 9.80665


def creeping(seed: int, share: float) -> pd.DataFrame:
    """Up and down twice on each cell, sampled; the second cell creeps by a share of its load.

    Its law is no exponential: a stretched one, which no row of the table has.
    """
    rng = np.random.default_rng([seed, 4])
    ladder = np.linspace(0.0, LARGEST_N, 6)
    hold = np.repeat([*ladder, *ladder[-2::-1]], int(HOLD_S * RATE_HZ))
    time_s = np.arange(hold.size) / RATE_HZ
    steps = np.diff(hold, prepend=0.0)
    late = np.zeros(hold.size)
    for at in np.flatnonzero(steps):
        since = (time_s[at:] - time_s[at]) / 40.0
        late[at:] += steps[at] * -np.expm1(-(since**0.6))
    made = []
    for cell in range(CELLS):
        scale = rng.uniform(0.8, 1.2)
        for session in range(2):
            load = hold * (1.0 + 5e-4 * rng.standard_normal())
            shown = load + (share * late if cell == 1 else 0.0)
            drift = 0.01 * np.cumsum(rng.standard_normal(hold.size)) / np.sqrt(hold.size)
            made.append(pd.DataFrame({
                "channel": f"C{cell}", "session": session, "time_s": time_s, "load_n": hold,
                "counts": scale * (shown + drift + 0.05 * rng.standard_normal(hold.size))
                + rng.normal(0.0, 0.1),
            }))  # fmt: skip
    return pd.concat(made)


def stacked(seed: int, light_kg: float) -> pd.DataFrame:
    """Stacks on four cells twice; the piece W3 is lighter than its stamp."""
    rng = np.random.default_rng([seed, 5])
    rows = []
    for cell in range(CELLS):
        scale, zero = rng.uniform(0.9, 1.1), rng.normal(0.0, 1.0)
        for session in range(2):
            gain = scale * (1.0 + 3e-4 * rng.standard_normal())
            for stack in (*STACKS, *STACKS[::-1]):
                pieces = [] if stack == "none" else stack.split("+")
                written = sum(PIECES[p] for p in pieces)
                truly = written - (light_kg if "W3" in pieces else 0.0)
                reading = gain * GRAVITY * truly * (1.0 + 2e-4 * rng.standard_normal()) + zero
                rows.append((f"C{cell}", session, stack, written, reading + rng.normal(0.0, 0.03)))
    return pd.DataFrame(rows, columns=["Cell", "Run", "Stack", "Nominal_kg", "Force_N"])


def diagnosed(run: Run, folder: Path, *more: str) -> DiagnosisRecord:
    answer = run("diagnose", "--recipe", folder / "r.toml", "--experiment", "weights",
                 "--no-pictures", "--out", folder / "out", *more)  # fmt: skip
    assert answer.exit_code == 0, answer.err
    return read_record(DiagnosisRecord, folder / "out/diagnosis.json")


def answered(record: DiagnosisRecord) -> set[str]:
    return {c.effect for c in record.causes} | {name for own in record.rivals for name in own}


FEW = few_or_all("creep", "creep_slow", "hysteresis", "nonlinearity", "bias_drift")


@FEW
@pytest.mark.parametrize(
    ("seed", "share"), [(1, 0.01), (2, 0.0), pytest.param(3, 0.01, marks=pytest.mark.slow)]
)
def test_a_cell_that_creeps_is_known_after_two_sessions(
    run: Run, tmp_path: Path, few: tuple[str, ...], seed: int, share: float
) -> None:
    creeping(seed, share).to_csv(tmp_path / "log.csv", index=False)
    (tmp_path / "r.toml").write_text('[data]\nweights = ["log.csv"]\n', encoding="utf-8")
    record = diagnosed(run, tmp_path, *few)
    if share:
        assert answered(record) & {"creep", "creep_slow"}, record.sentence
        assert record.causes[0].where == "C1"
    else:
        assert not answered(record), record.sentence


@pytest.mark.parametrize(("seed", "light_kg"), [(1, 0.05), (2, 0.0)])
def test_a_piece_that_is_lighter_than_its_stamp(
    run: Run, tmp_path: Path, seed: int, light_kg: float
) -> None:
    stacked(seed, light_kg).to_csv(tmp_path / "log.csv", index=False)
    made = run("init", tmp_path / "log.csv", "--output", tmp_path / "r.toml")
    assert made.exit_code == 0, made.err
    assert 'pieces = "Stack"' in (tmp_path / "r.toml").read_text(encoding="utf-8")
    record = diagnosed(run, tmp_path)
    if light_kg:
        (cause,) = record.causes
        assert (cause.effect, cause.written) == ("wrong_piece", "W3")
        assert cause.sd is not None
        assert abs(cause.size + light_kg * GRAVITY) < 3.0 * cause.sd
    else:
        assert not answered(record), record.sentence


def rounds_of_days(seed: int, per_k: float) -> pd.DataFrame:
    """Five days of three rounds on three cells, warmer from round to round; one scale follows."""
    rng = np.random.default_rng([seed, 6])
    ladder = np.linspace(0.0, LARGEST_N, 6)
    load = np.array([*ladder, *ladder[-2::-1]])
    rows = []
    for day in range(5):
        for number in range(3):
            kelvin = 18.0 + 2.5 * number + rng.normal(0.0, 0.5)
            for cell in range(3):
                gain = 1.0 + 2e-4 * rng.standard_normal() + (cell == 1) * per_k * (kelvin - 20.0)
                counts = gain * load + rng.normal(0.0, 0.05) + 0.02 * rng.standard_normal(load.size)
                rows.append(pd.DataFrame({
                    "channel": f"C{cell}", "session": day, "repeat": 3 * day + number,
                    "time_s": 86400.0 * day + 14400.0 * number + 60.0 * np.arange(load.size),
                    "temperature_degc": kelvin, "load_n": load, "counts": counts,
                }))  # fmt: skip
    return pd.concat(rows)


@few_or_all("temperature_scale", "temperature_bias", "nonlinearity", "bias_drift")
@pytest.mark.parametrize("per_k", [5e-4, 0.0])
def test_rounds_counted_on_over_days_are_sessions(
    run: Run, tmp_path: Path, few: tuple[str, ...], per_k: float
) -> None:
    rounds_of_days(1, per_k).to_csv(tmp_path / "log.csv", index=False)
    (tmp_path / "r.toml").write_text('[data]\nweights = ["log.csv"]\n', encoding="utf-8")
    record = diagnosed(run, tmp_path, *few)
    assert record.blocks == 45
    if per_k:
        cause = record.causes[0]
        assert (cause.effect, cause.where) == ("temperature_scale", "C1")
        assert answered(record) <= {"temperature_scale", "temperature_bias"}
        assert cause.sd is not None
        assert abs(cause.size - per_k) < 3.0 * cause.sd
    else:
        assert not answered(record), record.sentence


DAYS_DEGC = (18.4, 20.5, 22.0, 24.5, 27.5, 29.8)


def warmer_days(seed: int, share: float) -> pd.DataFrame:
    """Two rounds on four cells on each of six days; the span of the third follows the warmth."""
    rng = np.random.default_rng([seed, 9])
    ladder = np.linspace(0.0, LARGEST_N, 6)
    load = np.array([*ladder, *ladder[-2::-1]])
    rows = []
    for day, mean in enumerate(DAYS_DEGC):
        for number in range(2):
            kelvin = mean + rng.normal(0.0, 0.3)
            for cell in range(CELLS):
                span = share * np.expm1((kelvin - 23.0) / 14.0) * (cell == 2)
                gain = 1.0 + span + 4e-4 * rng.standard_normal()
                counts = gain * load + rng.normal(0.0, 0.05) + 0.02 * rng.standard_normal(load.size)
                rows.append(pd.DataFrame({
                    "channel": f"C{cell}", "session": day, "repeat": number,
                    "time_s": 86400.0 * day + 3600.0 * number + 60.0 * np.arange(load.size),
                    "temperature_degc": kelvin, "load_n": load, "counts": counts,
                }))  # fmt: skip
    return pd.concat(rows)


@few_or_all("temperature_scale", "temperature_bias", "nonlinearity", "bias_drift", "creep")
@pytest.mark.parametrize("share", [6e-3, 0.0])
def test_a_span_that_follows_six_days_is_named(
    run: Run, tmp_path: Path, few: tuple[str, ...], share: float
) -> None:
    """What sessions of one cell differ by is weighed in the noise that all cells' sessions have."""
    warmer_days(1, share).to_csv(tmp_path / "log.csv", index=False)
    (tmp_path / "r.toml").write_text('[data]\nweights = ["log.csv"]\n', encoding="utf-8")
    record = diagnosed(run, tmp_path, *few)
    if share:
        cause = record.causes[0]
        assert cause.where == "C2"
        # which of the two stands first hangs on the last bit of what is summed
        named = {cause.effect, *answered(record)}
        assert "temperature_scale" in named
        assert named <= {"temperature_scale", "temperature_bias"}
        # the mean slope of the span over these days
        slope = np.polyfit(DAYS_DEGC, share * np.expm1((np.array(DAYS_DEGC) - 23.0) / 14.0), 1)[0]
        assert cause.sd is not None
        assert cause.effect != "temperature_scale" or abs(cause.size - slope) < 3.0 * cause.sd
    else:
        assert not answered(record), record.sentence


def knees(seed: int, bow: float) -> pd.DataFrame:
    """Five repeats on four cells whose load bows as a power of it, each cell by a share of that."""
    rng = np.random.default_rng([seed, 7])
    ladder = np.array([0.0, 0.02, 0.05, 0.1, 0.2, 0.35, 0.5, 0.7, 0.85, 1.0]) * LARGEST_N
    load = np.array([*ladder, *ladder[-2::-1]])
    rows = []
    for cell, share in enumerate((1.0, 0.8, 0.5, 1.2)):
        for number in range(5):
            part = load / LARGEST_N
            curve = share * bow * LARGEST_N * (part**0.6 - part)
            gain = 1.0 + 4e-4 * rng.standard_normal()
            counts = gain * (load + curve) + rng.normal(0.0, 0.1)
            counts = counts + 0.05 * rng.standard_normal(load.size)
            rows.append(pd.DataFrame({
                "channel": f"C{cell}", "repeat": number, "load_n": load, "counts": counts,
                "time_s": 20.0 * np.arange(load.size),
            }))  # fmt: skip
    return pd.concat(rows)


@few_or_all("nonlinearity", "nonlinearity_cubic", "hinge", "dead_zone", "saturation", "hysteresis")
@pytest.mark.parametrize("bow", [0.02, 0.0])
def test_a_curve_that_the_table_lacks_is_one_of_its_curves(
    run: Run, tmp_path: Path, few: tuple[str, ...], bow: float
) -> None:
    knees(1, bow).to_csv(tmp_path / "log.csv", index=False)
    (tmp_path / "r.toml").write_text('[data]\nweights = ["log.csv"]\n', encoding="utf-8")
    said = answered(diagnosed(run, tmp_path, *few))
    curves = {"nonlinearity", "nonlinearity_cubic", "hinge", "dead_zone", "saturation"}
    assert bool(said) is (bow > 0.0)
    assert said <= curves
