"""The papers' page: its statistics against closed forms, and its pieces on a tiny setting."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from scipy import stats

from footcal_cli.core.simulation.gait import WalkPlan
from footcal_cli.core.simulation.plans import Plans
from footcal_cli.core.simulation.robots import Biped
from footcal_cli.core.simulation.scenario import simulate
from tests.papers import bench, walk_tables, walks
from tests.papers.__main__ import run
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
    found, papers = walks.compared_methods(merged, belief, truth, baseline, seed=0, learnt=())
    summary = walks.summary_of(found, papers, trial)
    assert {e["method"] for e in summary["errors"]} == set(walks.METHODS)
    assert {e["reference"] for e in summary["errors"]} == {"truth", "baseline"}
    assert summary["parameters"]["memory"]["gain_error"] < 0.02
    curves = walks.sensitivity_of(found, papers)
    assert [c["setting"] for c in curves] == ["omega_f", "omega_p", "omega_s"]
    middle = {c["cop_m"][2] for c in curves}
    assert len(middle) == 1  # × 1 is the same setting in each
    walks.figures_of(found, trial, tmp_path)
    assert {p.name for p in tmp_path.iterdir()} == {"walk_040_cop.png", "walk_040_vgrf.png"}


def _made_up(body: str, speed: float, session: int, trial: int) -> dict[str, object]:
    """A walk in which memory errs half as much as the window, and that a third of the static."""
    size = 1e-3 * (1.0 + 0.1 * session + 0.02 * trial + speed)
    errors = [
        {
            "method": method, "reference": reference, "cop_m": factor * size,
            "vgrf_n": 1e3 * factor * size, "cycle_cop_m": size, "cycle_cop_sd_m": 0.1 * size,
            "converged_s": 5.0,
        }
        for method, factor in (("before", 4.0), ("static", 3.0), ("window", 1.0), ("memory", 0.5))
        for reference in ("baseline", "truth")
    ]  # fmt: skip
    state = dict.fromkeys(
        ("gain_error", "bias_error_n", "gain_steady_sd", "bias_steady_sd_n"), 0.01
    )
    drift = {"drift_per_hour": 0.1, "drift_sd": 0.2}
    return {
        "body": body, "speed_mps": speed, "session": session, "trial": trial, "errors": errors,
        "parameters": dict.fromkeys(("static", "window", "memory"), state),
        "settling": [{"name": f"left_fl.{kind}", **drift} for kind in ("gain", "bias")],
    }  # fmt: skip


def test_the_tables_of_walks_say_what_is_in_the_walks() -> None:
    made = [
        _made_up(body, speed, session, trial)
        for body in walks.BODIES
        for speed in walks.SPEEDS_MPS
        for session in range(3)
        for trial in range(2)
    ]
    said = walk_tables.walking_tables(made)
    rows = [line for line in said.splitlines() if line.startswith("| exact | window / static")]
    assert len(rows) == 6
    assert all("0.33 [0.33, 0.33]" in row for row in rows)
    assert rows[0].split("|")[5].strip() == "0.55"  # 5.9 mm over 10.8 mm, as printed
    assert "| exact | 0.02 | static (Han) | 10.8 | 3.39 ± 0.27" in said
    points = walk_tables.open_points(made)
    assert "| 5 s, 18 of 18 |" in points
    assert "100 % within 2 of its sd" in points


@pytest.mark.slow
def test_the_whole_page(tmp_path: Path) -> None:
    """Every walk, pose and failure mode again; about ten minutes of one core."""
    page = tmp_path / "docs" / "papers.md"
    page.parent.mkdir()
    run(["--out", str(tmp_path / "papers"), "--page", str(page)])
    text = page.read_text("utf-8")
    for number in range(1, 16):
        assert f"\n| {number} | " in text
    linked = re.findall(r"\((pictures/papers/[^)]+)\)", text)
    assert len(linked) == 12
    assert all((page.parent / name).stat().st_size > 10_000 for name in linked)


def test_numbers_and_tables_read_well() -> None:
    assert shown(0.000123456) == "0.000123"
    assert shown(1576.4, 3) == "1576"
    assert table(("a", "b"), [("1", "2")]).splitlines() == ["| a | b |", "|---|---|", "| 1 | 2 |"]
