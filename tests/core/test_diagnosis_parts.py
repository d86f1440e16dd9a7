"""Small parts of a diagnosis by themselves, against what can be said of them by hand."""

from __future__ import annotations

from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from matplotlib.patches import Rectangle

from footcal_cli.core.diagnosis import comparison
from footcal_cli.core.diagnosis.attribution import Attribution
from footcal_cli.core.diagnosis.features import _curves
from footcal_cli.core.diagnosis.leftovers import _binned
from footcal_cli.core.diagnosis.menu import Menu
from footcal_cli.plots.diagnosis.ladder import _draw_parts
from footcal_cli.plots.style import new_figure
from footcal_cli.sheets.diagnosis.experiment import sharpening


def test_bins_of_a_signal_keep_its_sum_and_that_of_what_is_left() -> None:
    rng = np.random.default_rng(0)
    signal, left = rng.normal(size=500), rng.normal(size=500)
    middle, mean, count = _binned(signal, left)
    assert count.sum() == 500
    np.testing.assert_allclose(count @ middle, signal.sum(), atol=1e-9)
    np.testing.assert_allclose(count @ mean, left.sum(), atol=1e-9)
    assert np.all(np.diff(middle) > 0.0)


def test_a_signal_that_never_changes_has_no_curves() -> None:
    assert _curves(np.full(7, 3.0)).shape == (7, 0)


def test_two_experiments_are_proposed_of_different_kinds_where_there_are() -> None:
    def prospect(kind: str, minutes: float) -> Any:
        return SimpleNamespace(
            minutes=minutes, plan=SimpleNamespace(experiment=kind, words=f"{kind} {minutes:g}")
        )

    some = [prospect("walk", 9.0), prospect("walk", 2.0), prospect("stand", 5.0),
            prospect("weights", 7.0)]  # fmt: skip
    assert sharpening(cast(Menu, SimpleNamespace(prospects=some))) == ["walk 2", "stand 5"]
    assert sharpening(cast(Menu, SimpleNamespace(prospects=some[:2]))) == ["walk 2", "walk 9"]


def test_a_cause_is_decided_again_with_all_the_others_in_the_model(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    asked: list[list[str]] = []

    def decided(_subject: Any, others: list[str], _alone: Any, answer: str, _seed: int) -> Any:
        asked.append(list(others))
        return f"{answer} again", SimpleNamespace(values={})

    monkeypatch.setattr(comparison, "decided", decided)
    monkeypatch.setattr(comparison, "_began_as", lambda *_: False)
    monkeypatch.setattr(comparison, "all_are_something", lambda *_: True)
    subject = SimpleNamespace(
        case=SimpleNamespace(values={}), table={}, refitted=lambda others, start: (others, start)
    )
    causes: Any
    causes, _ = comparison.decided_again(
        cast(Any, subject), cast(Any, ["a", "b", "c", "d"]),
        cast(Any, SimpleNamespace(values={})), cast(Any, ["a", "b", "c", "d"]), seed=0,
    )  # fmt: skip
    assert asked == [["b", "c", "d"], ["a again", "c", "d"], ["a again", "b again", "d"]]
    assert causes == ["a again", "b again", "c again", "d"]


@pytest.mark.parametrize(("stands", "reach"), [(True, 9.0), (False, 4.0)])
def test_what_is_nothing_without_a_cause_begins_where_it_stood_beside_it(
    monkeypatch: pytest.MonkeyPatch, *, stands: bool, reach: float
) -> None:
    """Alone a loop may fall to zero, where its reach has no slope to find back along."""
    begun: list[float] = []

    def decided(_subject: Any, _others: Any, alone: Any, _answer: str, _seed: int) -> Any:
        begun.append(alone.values["loop.reach"])
        return "curve again", alone

    @dataclass(frozen=True)
    class Fitted:
        values: dict[str, float]

    monkeypatch.setattr(comparison, "decided", decided)
    monkeypatch.setattr(comparison, "_began_as", lambda *_: False)
    monkeypatch.setattr(comparison, "all_are_something", lambda *_: stands)
    subject = SimpleNamespace(
        case=SimpleNamespace(values={}), table={},
        refitted=lambda *_: Fitted({"loop.reach": 9.0}),
    )  # fmt: skip
    both = Fitted({"loop.reach": 4.0, "curve.size": 1.0})
    comparison.decided_again(
        cast(Any, subject), cast(Any, ["curve", "loop"]), cast(Any, both),
        cast(Any, ["curve", "loop"]), seed=0,
    )  # fmt: skip
    assert begun == [reach]


def test_shares_of_effects_are_drawn_in_per_cent() -> None:
    axes = new_figure(3.0).add_subplot()
    _draw_parts(axes, [Attribution("scale", 0.6, 0.2, 0.4), Attribution("bias", 0.5, 0.25, 0.3)])
    widths = [cast(Rectangle, bar).get_width() for bar in axes.patches]
    np.testing.assert_allclose(widths, [60.0, 50.0, 20.0, 25.0])


@pytest.mark.parametrize(("other", "again"), [("hinge", 1), ("crosstalk", 0)])
def test_a_cause_whose_first_name_is_another_one_by_now_is_not_decided_again(
    monkeypatch: pytest.MonkeyPatch, other: str, again: int
) -> None:
    """Its contenders would be none: the effect that it began as is in the model."""
    asked = []

    def decided(*_: Any) -> Any:
        asked.append(1)
        return _a("curve"), model

    def _a(effect: str) -> SimpleNamespace:
        return SimpleNamespace(signature=SimpleNamespace(effect=effect))

    model = SimpleNamespace(values={})
    monkeypatch.setattr(comparison, "decided", decided)
    monkeypatch.setattr(comparison, "all_are_something", lambda *_: True)
    subject = SimpleNamespace(case=SimpleNamespace(values={}), refitted=lambda *_: model, table={})
    began = SimpleNamespace(causes=(_a("crosstalk"),))
    comparison.decided_again(
        cast(Any, subject), cast(Any, [_a("curve"), _a(other)]), cast(Any, model),
        cast(Any, [began, began]), seed=0,
    )  # fmt: skip
    assert len(asked) == again
