"""Which causes are as large as what matters, and which are shown by moments alone."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from footcal_cli.core.diagnosis import ways
from footcal_cli.core.diagnosis.gain import Gain
from footcal_cli.core.diagnosis.rules import Rules
from footcal_cli.core.inference.evidence import Interval
from footcal_cli.core.inference.problem import Signature
from footcal_cli.sheets.diagnosis.words import matters


def row(effect: str, size: float, smallest: float) -> SimpleNamespace:
    return SimpleNamespace(
        signature=Signature(effect, effect, "left_fl", ""),
        size=Interval(size, size, size), smallest=smallest, visible=0.01,
    )  # fmt: skip


def _found(item: Any, gains: tuple[Gain, ...] = (), *, once: bool = False) -> Any:
    case = SimpleNamespace(tolerance_n=0.5, tolerance_nm=0.05)
    return SimpleNamespace(found=(item,), gains=gains, once=once, case=case)


@pytest.mark.parametrize(
    ("rival_size", "expected"), [(-0.085, True), (-0.005, False), (None, False)]
)
def test_of_a_set_any_effect_that_is_large_matters(
    rival_size: float | None, expected: bool
) -> None:
    """A narrow loop of 0.13 N may stand for a gain that is 8.5 % off."""
    rows = [row("hysteresis", 0.13, 1.1)]
    rivals = []
    if rival_size is not None:
        rows.append(row("scale_change", rival_size, 0.007))
        rivals = [rows[-1].signature]
    cause = SimpleNamespace(
        signature=rows[0].signature, size=rows[0].size, rivals=rivals
    )  # fmt: skip
    item = cast(Any, SimpleNamespace(cause=cause, answer=SimpleNamespace(effects=rows)))
    assert matters(_found(item), item) is expected


def test_what_happened_once_is_as_large_as_it_is() -> None:
    """Of a zero that drifts a tracked calibration leaves next to nothing to see."""
    drift = row("offset_drift", 0.05, 0.8)
    cause = SimpleNamespace(signature=drift.signature, size=drift.size, rivals=[])
    item = cast(Any, SimpleNamespace(cause=cause, answer=SimpleNamespace(effects=[drift])))
    assert not matters(_found(item), item)
    assert matters(_found(item, once=True), item)


def gain(unit: str, change: float, low: float) -> Gain:
    interval = Interval(change, low, 2 * change - low)
    return Gain("", unit, 1.0, 1.0 - change, interval, np.ones((3, 2)))


@pytest.mark.parametrize(("change", "low", "expected"), [(0.6, 0.4, True), (0.6, -0.1, False)])
def test_an_error_that_surely_falls_by_what_matters_does(
    change: float, low: float, expected: bool
) -> None:
    """The component that stands for a drift may be small where another one is large."""
    drift = row("offset_drift", 0.05, 0.8)
    cause = SimpleNamespace(signature=drift.signature, size=drift.size, rivals=[])
    item = cast(Any, SimpleNamespace(cause=cause, answer=SimpleNamespace(effects=[drift])))
    assert matters(_found(item, (gain("N", change, low),)), item) is expected


@pytest.mark.parametrize(
    ("gains", "moments"),
    [
        ([gain("N", 0.6, 0.5), gain("Nm", 0.5, 0.3)], False),
        ([gain("N", 0.03, 0.01), gain("Nm", 0.5, 0.3)], True),
        ([gain("N", 0.3, -0.1), gain("Nm", 0.5, 0.3)], True),
    ],
)
def test_what_no_force_surely_shows_is_shown_by_moments(
    monkeypatch: pytest.MonkeyPatch, gains: list[Gain], moments: bool
) -> None:
    monkeypatch.setattr(ways, "gains_of", lambda *_: gains)
    path = SimpleNamespace(current=SimpleNamespace(law=None))
    subject = SimpleNamespace(problem=None)
    assert ways.shows_in_moments(cast(Any, subject), cast(Any, path), Rules()) is moments
