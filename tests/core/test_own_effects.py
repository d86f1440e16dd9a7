"""Effects of a user's own: the parser reads arithmetic and nothing else, rows keep the contract."""

from __future__ import annotations

import numpy as np
import pytest

from footcal_cli.core.effects.contract import Effect, Scope, Stage
from footcal_cli.core.effects.formula import FormulaError, formula_of
from footcal_cli.core.effects.own import FormulaShape, OwnRow, own_effect
from footcal_cli.core.effects.promises import promises_of
from footcal_cli.core.log import Log
from tests.contract.logs import cell_log, difference, six_axis_log

KNOWN = frozenset({"k", "load", "shear"})


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("k * load", 6.0), ("-k + load ** 2 / 3", 1.0), ("max(load, 4) - min(k, 1.5)", 2.5),
        ("k * tanh(load) ** 2", 2.0 * np.tanh(3.0) ** 2), ("abs(-load) + 1e-1", 3.1),
        ("load / (k - k)", 0.0),
    ],
)  # fmt: skip
def test_arithmetic_is_computed(text: str, expected: float) -> None:
    values = {"k": np.array(2.0), "load": np.array(3.0)}
    assert formula_of(text, KNOWN)(values) == pytest.approx(expected)


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("__import__('os').system('true')", "neither number"),
        ("load.__class__", "neither number"), ("(lambda: 1)()", "neither number"),
        ("[load for load in k]", "neither number"), ("load[0]", "neither number"),
        ("open(load)", "no function 'open'"), ("exp(load, k)", "takes 1 argument"),
        ("exp(x=load)", "neither number"), ("load if k else 1", "neither number"),
        ("'a' * 1000000", "neither number"), ("k * laod", "did you mean 'load'"),
        ("True + load", "neither number"), ("k *", "no formula"), ("(" * 200, "no formula"),
        ("+".join(["load"] * 70), "longer|too many"), ("load @ k", "neither number"),
    ],
)  # fmt: skip
def test_anything_else_is_refused(text: str, why: str) -> None:
    with pytest.raises(FormulaError, match=why):
        formula_of(text, KNOWN)


def row(adds: str, **more: object) -> OwnRow:
    return OwnRow("mine", adds, "mend it", "-", 0.02, **more)  # type: ignore[arg-type]


ROWS = [
    row("k * load * exp(-load / w)", shapes=(FormulaShape("w", "N", (2.0, 4.0)),)),
    row("k * shear * load"), row("k * cop_x * load", per=Scope.FOOT), row("k * temperature"),
    row("k * time * load / 30", per=Scope.ROBOT), row("k * (foot_load - load)"),
    row("k * shear_x * sin(phase)", experiments=("hang",), per=Scope.LEG),
]  # fmt: skip


@pytest.mark.parametrize("written", ROWS, ids=lambda r: r.adds)
def test_rows_keep_the_contract(written: OwnRow) -> None:
    assert [p.says for p in promises_of(own_effect(written)) if not p.kept] == []


def test_a_broken_promise_is_seen() -> None:
    too_large = own_effect(OwnRow("mine", "k * load", "mend it", "-", 3.0))
    kept = {p.says: p.kept for p in promises_of(too_large)}
    assert not kept["removing it undoes it"]


def shown(effect: Effect, log: Log, size: float) -> np.ndarray:
    units = {"channel": len(log.channels), "robot": 1, "leg": 2, "foot": 2}[effect.scope]
    theta = {"mine": np.full(units, size)}
    return effect.apply(log, theta, None)[0].readings - log.readings


def test_signals_are_what_they_say() -> None:
    log = cell_log()
    readings, acc = log.readings, log.known["com_acc_mps2"]
    share = readings[:, :4].sum(axis=1) / readings.sum(axis=1)
    shear = 5.3 * acc[:, 0] * share
    added = shown(own_effect(row("k * shear_x")), log, 0.1)
    np.testing.assert_allclose(added[:, :4], 0.1 * np.tile(shear[:, None], 4))
    place = log.known["cell_pos_m"][:, 4:, 1]
    cop_y = (place * readings[:, 4:]).sum(axis=1) / readings[:, 4:].sum(axis=1)
    added = shown(own_effect(row("k * cop_y")), log, 2.0)
    np.testing.assert_allclose(added[:, 7], 2.0 * cop_y)
    added = shown(own_effect(row("k * time")), log, 1.0)
    np.testing.assert_allclose(added[:, 0], log.time_s - log.time_s[0], atol=1e-12)
    hung = six_axis_log("hang")
    added = shown(own_effect(row("k * shear", experiments=("hang",))), hung, 0.5)
    np.testing.assert_allclose(
        added[:, 6], 0.5 * np.hypot(hung.readings[:, 6], hung.readings[:, 7])
    )
    back = own_effect(row("k * foot_load"))
    distorted = log.with_readings(log.readings + shown(back, log, 0.05))
    restored, _ = back.remove(distorted, {"mine": np.full(8, 0.05)}, None)
    assert difference(log, restored) < 1e-12


def test_where_it_acts_follows_from_its_signals() -> None:
    assert own_effect(row("k * shear")).experiments == ("walk", "hang", "pose")
    assert own_effect(row("k * shear")).needs == ("mass_kg", "com_acc_mps2")
    hung = own_effect(row("k * phase * load"))
    assert (hung.experiments, hung.stage, hung.needs) == (
        ("hang", "pose"), Stage.SIX_AXIS, ("phase_rad",),
    )  # fmt: skip


@pytest.mark.parametrize(
    ("written", "why"),
    [
        (row("1 + k"), "where k is zero"), (row("load"), "does not use 'k'"),
        (row("k * cop_x", experiments=("hang",)), "not known in hang"),
        (row("k * phase * cop_x"), "not known in any"),
        (row("load", size="load"), "something else"),
    ],
)  # fmt: skip
def test_rows_that_cannot_be_are_refused(written: OwnRow, why: str) -> None:
    with pytest.raises(FormulaError, match=why):
        own_effect(written)
