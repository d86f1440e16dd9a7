"""The papers' page: its statistics against closed forms, and its pieces on a tiny setting."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy import stats

from footcal_cli.core.simulation.gait import WalkPlan
from footcal_cli.core.simulation.robots import Biped
from footcal_cli.core.simulation.scenario import Plans, simulate
from tests.papers import bench, walks
from tests.papers.formats import shown, table
from tests.papers.statistics import converged_after, holm, paired, spread


def test_paired_ratio_and_p_are_the_textbooks() -> None:
    rng = np.random.default_rng(3)
    theirs = rng.uniform(1.0, 2.0, 7)
    ours = theirs * np.exp(rng.normal(-0.3, 0.1, 7))
    found = paired(ours, theirs)
    book = stats.ttest_rel(np.log(ours), np.log(theirs))
    interval = book.confidence_interval()
    assert found.t_p == pytest.approx(book.pvalue)
    assert (found.low, found.high) == pytest.approx((np.exp(interval.low), np.exp(interval.high)))
    assert found.ratio == pytest.approx(stats.gmean(ours) / stats.gmean(theirs))
    assert found.n == 7
    # all seven on one side: the smallest p a signed-rank test of seven can give
    assert paired(0.5 * theirs, theirs * np.arange(1, 8)).wilcoxon_p == pytest.approx(2 / 2**7)


def test_holm_on_a_worked_example() -> None:
    np.testing.assert_allclose(holm([0.01, 0.04, 0.03, 0.005]), [0.03, 0.06, 0.06, 0.02])


def test_components_of_variance_are_found_where_they_were_put() -> None:
    rng = np.random.default_rng(5)
    session = np.repeat(np.arange(400), 4)
    values = 3.0 + 2.0 * rng.normal(size=400)[session] + 0.5 * rng.normal(size=1600)
    found = spread(values, session)
    assert found.within_sd == pytest.approx(0.5, rel=0.05)
    assert found.between_sd == pytest.approx(2.0, rel=0.1)
    assert spread([1.0, 3.0, 1.0, 3.0], [0, 0, 1, 1]).between_sd == 0.0


def test_an_error_has_settled_once_it_stays_in_its_last_band() -> None:
    time_s = np.arange(30.0)
    errors = 1.0 + 5.0 * (time_s < 7) + 0.01 * (-1.0) ** np.arange(30)
    assert converged_after(errors, time_s) == 7.0
    assert np.isnan(converged_after(time_s**0 + 3.0 * (time_s == 19), time_s))


def test_table_2_comes_out_as_printed() -> None:
    rows = bench.table_2()
    assert len(rows) == 8
    for row in rows:
        np.testing.assert_allclose(row.fitted, row.printed, rtol=2e-8)


def test_a_short_walk_gives_every_figure_of_the_page(tmp_path: Path) -> None:
    trial = walks.Trial("exact", 0.04, 0, 0)
    values, baseline = walks.mounted(0)
    scale_error = [baseline[n] / values[n] - 1 for n in baseline.names if n.endswith(".scale")]
    assert np.abs(scale_error).max() < 5e-3
    made = simulate(
        "walk", Biped(), Plans(walk=WalkPlan(duration_s=14.0)), [], seed=1, given=values
    )
    merged, belief, truth = walks.merged_of(made, Biped())
    found = walks.compared_methods(merged, belief, truth, baseline, seed=0, learnt=())
    summary = walks.summary_of(found, trial)
    assert {e["method"] for e in summary["errors"]} == set(walks.METHODS)
    assert {e["reference"] for e in summary["errors"]} == {"truth", "baseline"}
    assert summary["parameters"]["memory"]["gain_error"] < 0.02
    curves = walks.sensitivity_of(found)
    assert [c["setting"] for c in curves] == ["omega_f", "omega_p", "omega_s"]
    middle = {c["cop_m"][2] for c in curves}
    assert len(middle) == 1  # × 1 is the same setting in each
    walks.figures_of(found, trial, tmp_path)
    assert {p.name for p in tmp_path.iterdir()} == {"walk_040_cop.png", "walk_040_vgrf.png"}


def test_numbers_and_tables_read_well() -> None:
    assert shown(0.000123456) == "0.000123"
    assert shown(1576.4, 3) == "1576"
    assert table(("a", "b"), [("1", "2")]).splitlines() == ["| a | b |", "|---|---|", "| 1 | 2 |"]
