"""Studies of minutes: coverage of intervals, rights and wrongs of the ladder, Table 3 with spread.

Run by ``pytest -m slow``; the default tests hold smaller versions of each.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import replace

import numpy as np
import pytest

from footcal_cli.core.bench.channel import fit_channel
from footcal_cli.core.bench.cop_study import study_cop
from footcal_cli.core.bench.ladder import climb
from footcal_cli.core.bench.terms import creep, effect_term, hysteresis
from footcal_cli.core.effects import TABLE
from tests.core.bench_data import Staircase
from tests.core.test_bench_ladder import CELL, covered, record
from tests.core.test_placements import bench, half_width_m, rmse

pytestmark = pytest.mark.slow
LEVEL = (0.93, 0.97)


def between(share: float, runs: int) -> bool:
    """93–97 %, widened by two standard errors of a share of 95 % in so many runs."""
    margin = 2.0 * np.sqrt(0.95 * 0.05 / runs)
    return bool(LEVEL[0] - margin < share < LEVEL[1] + margin)


@pytest.mark.parametrize("session_sd_n", [0.03, 0.1, 0.3])
def test_scale_bias_and_predictions_cover(session_sd_n: float) -> None:
    stairs = Staircase(sessions=6, session_sd_n=session_sd_n, quadratic=1e-4)
    runs, hits, predicted = 1000, Counter[str](), []
    for seed in range(runs):
        fit = fit_channel(record(stairs, seed), (effect_term(TABLE["nonlinearity"]),))
        for name, truth in (("scale", stairs.scale), ("quadratic", 1e-4)):
            hits[name] += covered(fit, name, truth)
        new = record(replace(stairs, sessions=1), 100_000 + seed)
        found = fit.predict(new)
        predicted.append(np.mean(np.abs(found.load_n - new.load_n) < found.half_width_n()))
    shares = {name: hits[name] / runs for name in hits} | {"prediction": float(np.mean(predicted))}
    print(session_sd_n, shares)  # noqa: T201 - a study reports its numbers
    assert all(between(share, runs) for share in shares.values()), shares


def test_memory_terms_cover() -> None:
    looped = Staircase(hysteresis_width=0.3, hysteresis_reach=5.0, steps=25, sessions=2)
    crept = Staircase(creep=0.01, creep_time=60.0, rows_per_hold=6, hold_s=60.0)
    runs, hits = 400, Counter[str]()
    for seed in range(runs):
        rows = record(looped, seed)
        fit = fit_channel(rows, hysteresis(60.0).terms)
        hits["hysteresis_width"] += covered(fit, "hysteresis_width", 0.3)
        hits["scale beside it"] += covered(fit, "scale", looped.scale)
        rows = record(crept, seed)
        fit = fit_channel(rows, creep(rows, 1).terms)
        hits["creep"] += covered(fit, "creep", 0.01)
        hits["creep_time"] += covered(fit, "creep_time", 60.0)
    shares = {name: hit / runs for name, hit in hits.items()}
    print(shares)  # noqa: T201
    assert all(between(share, runs) for share in shares.values()), shares


def test_the_ladder_is_right_as_often_as_it_should_be() -> None:
    perfect = Counter(climb(record(Staircase(), seed)).model for seed in range(60))
    print("perfect", perfect)  # noqa: T201
    assert perfect["affine"] >= 54
    looped = Staircase(hysteresis_width=0.18)
    ladders = [climb(record(looped, seed)) for seed in range(40)]
    models = Counter(ladder.model for ladder in ladders)
    sizes = [
        ladder.chosen.estimates[f"{CELL}.hysteresis_width"]
        for ladder in ladders
        if ladder.model == "hysteresis"
    ]
    stated = np.array([ladder.affine_scale_error for ladder in ladders])
    true = np.array(
        [ladder.affine.estimates[f"{CELL}.scale"] / looped.scale - 1 for ladder in ladders]
    )
    print("0.3 %", models, np.mean(sizes), np.std(sizes, ddof=1))  # noqa: T201
    print("affine scale off, true and stated", true.mean(), stated.mean(), np.std(stated - true))  # noqa: T201
    found = sum(ladder.rungs[:1] != () and "hysteresis" in ladder.rungs[0] for ladder in ladders)
    assert found >= 38
    assert np.mean(np.abs(np.array(sizes) / 0.18 - 1.0) < 0.2) > 0.9


@pytest.mark.parametrize(
    ("crosstalk", "position_m"), [(0.0, 0.0), (0.03, 0.0), (0.0, 0.004), (0.03, 0.004)]
)
def test_table_3_with_spread(crosstalk: float, position_m: float) -> None:
    rows_of: dict[str, list[tuple[float, ...]]] = {}
    verdicts, inside = Counter[str](), []
    for seed in range(20):
        _, before, rows, held = bench(seed, crosstalk=crosstalk, position_m=position_m)
        fitted, new = rows.select(~held), rows.select(held)
        study = study_cop(fitted)
        verdicts["physics"] += "beats the polynomial" in study.verdict()
        verdicts["polynomial"] += "beats the physical" in study.verdict()
        raw = np.sqrt(np.mean((before.total_n - before.load_n) ** 2))
        rows_of.setdefault("before", []).append((rmse(before.raw_cop_m, before), 0.0, raw, 0.0))
        for result in study.results:
            totals = [
                np.sqrt(np.mean((result.fit.total_n(some) - some.load_n) ** 2))
                for some in (fitted, new)
            ]
            rows_of.setdefault(result.name, []).append(
                (result.cop_rmse_m, rmse(result.fit.cop_m(new), new), *totals)
            )
        chosen = study.chosen
        error = np.abs(chosen.fit.cop_m(new) - new.hole_m)[new.valid]
        inside.append(np.mean(error < half_width_m(chosen, new)[new.valid]))
    print(crosstalk, position_m, dict(verdicts), "cover", np.mean(inside))  # noqa: T201
    for name, values in rows_of.items():
        mean, sd = np.mean(values, axis=0), np.std(values, axis=0, ddof=1)
        print(f"{name:38}", " ".join(f"{m:.3g}±{s:.2g}" for m, s in zip(mean, sd, strict=True)))  # noqa: T201
    if crosstalk or position_m:
        assert verdicts["physics"] >= 18
    physics = np.mean(rows_of["crosstalk and cell positions"], axis=0)
    assert physics[1] < 7e-4
    assert physics[3] < 0.08
    assert 0.93 < np.mean(inside) < 0.985
