"""The named cause against its look-alikes: who is out, and in which metric."""

from __future__ import annotations

import itertools
from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from scipy import stats

from footcal_cli.core.diagnosis import ends, field, growth
from footcal_cli.core.diagnosis.answer import Cause, EffectStatus
from footcal_cli.core.diagnosis.bridge import problem_from
from footcal_cli.core.diagnosis.by_cell import in_each_cell
from footcal_cli.core.diagnosis.comparison import _worse
from footcal_cli.core.diagnosis.field import Field, best_of
from footcal_cli.core.diagnosis.investigation import Investigation, investigate
from footcal_cli.core.diagnosis.rivals import (
    Tried,
    excess_of,
    likelier,
    odds_of,
    of_two_classes,
    share_for_form,
)
from footcal_cli.core.diagnosis.rules import Rules
from footcal_cli.core.diagnosis.signals import describe
from footcal_cli.core.diagnosis.stated import stated_size
from footcal_cli.core.diagnosis.subject import Subject
from footcal_cli.core.effects import TABLE
from footcal_cli.core.inference.case import Case, rows_of
from footcal_cli.core.inference.evidence import (
    Interval,
    largest_excess,
    sign_flip_group,
    sign_flip_mean,
    sign_patterns,
)
from footcal_cli.core.inference.problem import Signature
from footcal_cli.core.inference.refit import Refit
from footcal_cli.core.inference.scatter import Scatter
from footcal_cli.core.inference.whitening import Noise
from footcal_cli.plots.diagnosis.residuals import plot_driver
from footcal_cli.sheets.diagnosis.evidence import table_rows
from footcal_cli.sheets.diagnosis.rivals import next_best
from tests.core.test_diagnosis_bridge import ROBOT, weights_case, with_rivals

CURVES = {k: TABLE[k] for k in ("nonlinearity", "nonlinearity_cubic", "hinge", "dead_zone")}
SIGNS = sign_patterns(12)


def cause_of(signature: Signature, size: float = 0.0) -> Cause:
    around = Interval(size, size, size)
    return Cause(signature, around, 0.0, around, 0, 0.0, (), ())


def tried(effect: str, loss: float, p: float) -> Tried:
    empty = np.empty((0, 0))
    scatter = Scatter(empty, np.empty(0), 0.0, np.empty((0, 0)))
    fitted = Refit(None, {}, (), (), scatter, empty, np.empty(0), None, True, None)  # type: ignore[arg-type]
    own = loss + 0.1 * np.cos(np.arange(12.0))
    cause = cause_of(Signature(effect, "", "all cells", ""))
    return Tried(cause, fitted, own, None, p, 0.0)  # type: ignore[arg-type]


def of_rows(rows: int) -> Noise:
    """Noise of which only the number of rows is asked."""
    return cast(Noise, SimpleNamespace(whitener=SimpleNamespace(kept=np.empty(rows))))


def out(other: Tried, best: Tried, gain: float) -> bool:
    significant = sign_flip_mean(other.loss - best.loss, SIGNS) < Rules().alpha_rival
    return _worse(TABLE, other, best, best.loss, gain, significant, Rules())


def test_a_look_alike_is_out_where_it_leaves_something_and_the_best_does_not() -> None:
    best = tried("nonlinearity", 1.0, 0.4)
    assert out(tried("hinge", 1.5, 1e-4), best, 1000.0)
    assert not out(tried("hinge", 1.5, 0.01), best, 1000.0)
    assert not out(tried("hinge", 1.5, 1e-4), tried("nonlinearity", 1.0, 1e-4), 1000.0)
    # none leaves nothing: a good part of the gain decides
    assert out(tried("hinge", 1.5, 1e-4), tried("nonlinearity", 1.0, 1e-4), 30.0)


def test_what_does_not_look_alike_is_out_by_its_loss_alone() -> None:
    best = tried("nonlinearity", 1.0, 1e-4)
    assert out(tried("creep", 1.5, 0.5), best, 1000.0)
    assert not out(tried("creep", 1.0, 1e-4), best, 1000.0)


def test_a_true_rival_is_seldom_out_however_much_blocks_scatter() -> None:
    """Blocks whose differences are ``N(−μ, 4 s μ)``, as where the other model is true with noise s.

    No more often than the signs of blocks may put it out (`Rules.alpha_rival`). With s = 9 a law
    that believes s = 1 does so with ``P(N(−T, 36 T) > 9.2) = 16 %`` at ``T = 12 μ = 9.2``.
    """
    rng, noise = np.random.default_rng(6), of_rows(1200)
    for mean in (0.3, 0.77, 2.0):
        differences = rng.normal(-mean, np.sqrt(36.0 * mean), (2000, 12))
        wrong = [likelier(np.full(12, 100.0), 100.0 + d, noise, 0.01) for d in differences]
        assert np.mean(wrong) < Rules().alpha_rival


@pytest.mark.parametrize("scatter", [1.0, 9.0])
def test_odds_of_two_models_are_as_often_right_as_they_say(scatter: float) -> None:
    """One of two models is true by a throw; blocks whose differences are ``N(±μ, 4 s μ)``."""
    rng, noise = np.random.default_rng(8), of_rows(1200)
    said, true = np.empty(1500), rng.random(1500) < 0.5
    for i, first in enumerate(true):
        mean = scatter * 10.0 ** rng.uniform(-2.0, 0.7)
        lost = rng.normal(mean if first else -mean, np.sqrt(4.0 * scatter * mean), 12)
        said[i] = 1.0 / (1.0 + odds_of(np.full(12, 100.0), 100.0 + lost, noise))
    for low, high in itertools.pairwise((0.0, 0.1, 0.35, 0.65, 0.9, 1.0)):
        there = (said >= low) & (said <= high)
        assert there.sum() > 100
        assert abs(said[there].mean() - true[there].mean()) < 0.1


def test_a_set_shares_its_probability_by_odds_and_a_name_has_none() -> None:
    mine, other = tried("hinge", 1.0, 0.5).cause, tried("dead_zone", 1.0, 0.5).cause.signature
    assert replace(mine, rivals=(other,), odds={"dead_zone": 0.25}).probability == {
        "hinge": pytest.approx(0.8), "dead_zone": pytest.approx(0.2),
    }  # fmt: skip
    assert mine.probability == {}


def test_a_wrong_rival_is_out_where_blocks_agree() -> None:
    rng, noise = np.random.default_rng(7), of_rows(1200)
    differences = rng.normal(3.0, np.sqrt(4.0 * 3.0), (400, 12))
    out_of_it = [likelier(np.full(12, 100.0), 100.0 + d, noise, 0.01) for d in differences]
    assert np.mean(out_of_it) > 0.9


def test_what_looks_like_a_better_contender_is_tried_too(monkeypatch: pytest.MonkeyPatch) -> None:
    """Seen as a misplaced cell: crosstalk looks like that, a hinge like crosstalk only."""
    alike = {"cell_position": ("cell_position", "crosstalk"), "crosstalk": ("crosstalk", "hinge")}
    losses = {"cell_position": 3.0, "crosstalk": 1.2, "hinge": 1.0}
    named = {name: tried(name, loss, 0.5) for name, loss in losses.items()}

    def refitted(*given: Any) -> list[Any]:
        about, taken = given[-2].signature.effect, given[-1]
        kin = [n for n in alike.get(about, ()) if n not in taken]
        return [(named[n].cause, named[n].fitted, n) for n in kin]

    monkeypatch.setattr(field, "refitted", refitted)
    monkeypatch.setattr(field, "with_zeros", lambda *given: [])
    monkeypatch.setattr(field, "inside", lambda subject, every: every)
    monkeypatch.setattr(field, "_of_the_likeliest", lambda judged: of_rows(12))
    monkeypatch.setattr(field, "_family", lambda *given: [])
    monkeypatch.setattr(field.Field, "judged", lambda self, one, fair: named[one[2]])
    subject = cast(Any, SimpleNamespace(table=TABLE, without_credit=lambda bare, fitted: bare))
    answer = cast(Any, SimpleNamespace(causes=(named["cell_position"].cause,)))
    _, all_tried, best = field.field_of(subject, [], None, answer, SIGNS, Rules(), frozenset())
    assert [t.cause.signature.effect for t in all_tried] == ["cell_position", "crosstalk", "hinge"]
    assert best is named["hinge"]


def test_of_a_kind_the_one_that_leaves_nothing_is_best() -> None:
    least = tried("hinge", 0.9, 1e-4)
    whole = tried("nonlinearity", 1.0, 0.4)
    assert best_of(TABLE, [least, whole], SIGNS, Rules()) is whole
    assert best_of(TABLE, [least, tried("creep", 1.0, 0.4)], SIGNS, Rules()) is least


def test_a_low_pass_that_is_undone_hides_what_it_leaves_in_louder_noise() -> None:
    delay = tried("delay", 1.0, 1e-4)
    assert best_of(TABLE, [delay, tried("lag", 1.05, 0.4)], SIGNS, Rules()) is delay
    lag = tried("lag", 0.95, 1e-4)
    assert best_of(TABLE, [delay, lag], SIGNS, Rules()) is lag


def test_what_surely_leaves_twice_as_much_is_not_whole() -> None:
    """Beside the best with 0.9, 2.0 surely leaves as much again, and is no answer."""
    least, much = tried("hinge", 0.9, 1e-4), tried("nonlinearity", 2.0, 0.4)
    some = tried("nonlinearity", 1.5, 0.4)
    assert best_of(TABLE, [least, some], SIGNS, Rules()) is some
    assert best_of(TABLE, [least, much], SIGNS, Rules()) is least
    unsure = replace(much, loss=much.loss + 3.0 * np.resize([1.0, -1.0], 12))
    assert best_of(TABLE, [least, unsure], SIGNS, Rules()) is unsure


def test_what_a_model_may_leave_is_known_as_well_as_its_leftover() -> None:
    """The bound holds the true noncentrality in 95 %, however much was found."""
    rng = np.random.default_rng(1)
    for true in (0.0, 10.0, 60.0):
        found = rng.noncentral_chisquare(4, max(true, 1e-9), 400)
        held = [true <= largest_excess(float(f), 4) + 1e-6 for f in found]
        assert np.mean(held) > 0.92
    assert largest_excess(3.0, 0) == 0.0


def test_many_candidates_together_have_a_level_of_their_own() -> None:
    rng = np.random.default_rng(0)
    shared = rng.standard_normal((400, 12, 1))
    p = [
        sign_flip_group(s + 0.3 * rng.standard_normal((12, 5)), SIGNS)
        for s in shared
    ]  # fmt: skip
    assert np.mean(np.array(p) < 0.05) == pytest.approx(0.05, abs=0.03)
    assert sign_flip_group(np.ones((12, 3)), SIGNS) == pytest.approx(1 / len(SIGNS))
    assert sign_flip_group(np.zeros((12, 3)), SIGNS) == 1.0


@pytest.fixture(scope="module")
def bent() -> Case:
    curve = ("nonlinearity", {"all": ROBOT.channels}, {"all.quadratic": 1e-3})
    return weights_case(12, curve, robot=ROBOT)


@pytest.fixture(scope="module")
def found_bent(bent: Case) -> Investigation:
    return investigate(bent, CURVES, describe)


def test_a_bent_curve_is_named_without_its_look_alikes(found_bent: Investigation) -> None:
    found = found_bent
    assert found.verdict == "named"
    assert with_rivals(found) == {"nonlinearity"}
    rows = {row.signature.effect: row for row in table_rows(found)}
    assert rows["nonlinearity"].status is EffectStatus.PRESENT
    # the report compares it with the curve that came nearest in a refit of its own
    compared = found.found[0].cause.compared
    nearest = min(compared, key=lambda name: compared[name].excess.value)
    assert compared[nearest].excess.value > 0.0
    told = next_best(found)
    assert told is not None
    assert told.startswith(f"The next best cause, {nearest.replace('_', ' ')}, ")


def test_the_fitted_effect_is_drawn_through_the_means_that_it_explains(
    found_bent: Investigation,
) -> None:
    lines = {line.get_label(): line for line in plot_driver(found_bent).axes[0].lines}
    mean = next(line for label, line in lines.items() if str(label).startswith("mean"))
    off = np.asarray(lines["fitted effect"].get_ydata()) - np.asarray(mean.get_ydata())
    assert np.abs(off).max() < 0.2 * np.ptp(np.asarray(mean.get_ydata()))


def test_the_excess_of_an_error_and_its_interval() -> None:
    """21 % more squared error is 10 % more error; MacKinnon's CV3 by hand."""
    best = np.array([1.0, 2.0, 3.0, 4.0])
    same = excess_of(1.21 * best, best)
    assert (same.low, same.value, same.high) == pytest.approx((0.1, 0.1, 0.1))
    rng = np.random.default_rng(3)
    other = best * rng.uniform(1.0, 1.4, 4)
    without = [np.sqrt(np.delete(other, i).sum() / np.delete(best, i).sum()) for i in range(4)]
    whole = np.sqrt(other.sum() / best.sum())
    spread = float(np.sqrt(3.0 / 4.0 * np.sum((without - whole) ** 2)))
    found = excess_of(other, best)
    assert found.value == pytest.approx(whole - 1.0)
    assert found.high - found.value == pytest.approx(stats.t.ppf(0.975, 3) * spread)


def test_form_costs_a_rival_of_the_other_class_alone() -> None:
    smooth, cubic, knee = (
        cause_of(Signature(name, "", "all cells", ""))
        for name in ("nonlinearity", "nonlinearity_cubic", "hinge")
    )
    assert of_two_classes(smooth, knee)
    assert of_two_classes(knee, cubic)
    assert not of_two_classes(smooth, cubic)
    assert not of_two_classes(smooth, cause_of(Signature("creep", "", "all cells", "")))
    rules = Rules()
    assert share_for_form(tried("hinge", 1.0, 0.4), rules.other_form, rules) == rules.other_form
    assert share_for_form(tried("hinge", 1.0, 1e-4), rules.other_form, rules) == rules.wrong_form


def test_positions_of_its_own_in_every_cell_are_no_proof() -> None:
    """They would copy every linear mixture of the readings in the moments."""
    case = weights_case(14, None)
    rows = rows_of(case)
    subject = Subject(case, problem_from(case, rows, (), describe), TABLE, describe)
    best = tried("cell_position", 1.0, 0.4)
    noise = subject.problem.law
    chosen, fitted, _ = in_each_cell(Field(subject, [], None, SIGNS, noise, []), best, Rules())
    assert chosen is best.cause
    assert fitted is best.fitted


def test_of_several_sizes_the_one_asked_for_is_stated() -> None:
    x, y = Interval(1.0, 0.9, 1.1), Interval(2.0, 1.9, 2.1)
    names = ("a.cell_correction_x", "a.cell_correction_y")
    model = replace(tried("cell_position", 0.0, 1.0).fitted, names=names, intervals=(x, y))
    effect = TABLE["cell_position"]
    assert stated_size(None, model, effect, "a", "cell_correction_y") == y  # type: ignore[arg-type]
    assert stated_size(None, model, effect, "a", "cell_correction_x") == x  # type: ignore[arg-type]


def test_where_the_best_does_not_stand_its_refit_the_next_best_is_tried(
    bent: Case, found_bent: Investigation, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Its p is that of the family with the one that failed."""
    first = found_bent
    assert {f.cause.signature.effect for f in first.found} == {"nonlinearity"}
    monkeypatch.setattr(growth, "is_something", lambda c, *_: c.signature.effect != "nonlinearity")
    second = investigate(bent, CURVES, describe)
    (tried,) = second.rounds[0].causes
    assert tried.signature.effect != "nonlinearity"
    found = {f.cause.signature.effect for f in (*second.found, *second.nearest)}
    assert found
    assert "nonlinearity" not in found
    library, p = first.rounds[0].library, first.rounds[0].search.first.p
    assert tried.p == p[library.causes.index(tried.signature.cause)]


def test_a_size_at_an_end_of_its_range_ends_the_search(bent: Case) -> None:
    rows = rows_of(bent)
    subject = Subject(bent, problem_from(bent, rows, CURVES.values(), describe),
                      CURVES, describe)  # fmt: skip
    cause = cause_of(
        next(s for s in subject.problem.signatures
             if (s.effect, s.where) == ("nonlinearity", "all cells"))
    )  # fmt: skip
    fitted = subject.refitted([cause], {"all.quadratic": 1e-3})
    assert not ends.at_an_end(subject, [cause], fitted)
    upper = CURVES["nonlinearity"].size.upper
    at_end = replace(fitted, values={**fitted.values, "all.quadratic": upper})
    assert ends.at_an_end(subject, [cause], at_end)
