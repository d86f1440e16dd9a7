"""Which effect of a set of rivals stands for all of them."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from footcal_cli.core.diagnosis.answer import Cause, Compared
from footcal_cli.core.diagnosis.likeliest import _likeliest
from footcal_cli.core.inference.evidence import Interval
from footcal_cli.core.inference.problem import Signature

ANSWER: Any = SimpleNamespace(effects=())


def a_set(odds: dict[str, float]) -> Cause:
    names = ("hinge", *odds)
    first, *others = (Signature(name, name, "left_a", "-") for name in names)
    excess = Interval(-0.02, -0.04, 0.01)
    return Cause(
        first, Interval(0.04, 0.03, 0.05), 1e-4, Interval(0.2, 0.1, 0.3), 30, 0.0, tuple(others),
        (), {name: Compared(excess, 0.4, 0.1) for name in odds}, odds,
    )  # fmt: skip


def test_the_most_probable_of_a_set_takes_the_first_place() -> None:
    cause = a_set({"saturation": 1.0, "dead_zone": 10.0})
    likelier = _likeliest(cause, ANSWER)
    assert likelier is not None
    assert likelier.signature.effect == "dead_zone"
    assert [s.effect for s in likelier.rivals] == ["hinge", "saturation"]
    assert likelier.probability == pytest.approx(cause.probability)
    found = likelier.compared["hinge"]
    assert found.excess.value == pytest.approx(1.0 / 0.98 - 1.0)
    assert found.excess.low < 0.0 < found.excess.high
    assert (found.left, found.left_by_named) == (0.1, 0.4)


@pytest.mark.parametrize("odds", [{"saturation": 1.0}, {"saturation": 0.2}, {}])
def test_a_first_that_is_as_probable_stays(odds: dict[str, float]) -> None:
    assert _likeliest(a_set(odds), ANSWER) is None
