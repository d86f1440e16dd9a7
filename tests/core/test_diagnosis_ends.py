"""A cause with a size for every cell, where some cells ask for a sign that it cannot have."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest

from footcal_cli.core.diagnosis import by_cell
from footcal_cli.core.diagnosis.answer import Cause
from footcal_cli.core.diagnosis.ends import against_other_sign, held_at_zero
from footcal_cli.core.diagnosis.rules import Rules
from footcal_cli.core.diagnosis.unnamed import Unnamed
from footcal_cli.core.effects import TABLE
from footcal_cli.core.inference.evidence import Interval, sign_patterns
from footcal_cli.core.inference.problem import Problem, Signature
from footcal_cli.core.inference.refit import Refit
from footcal_cli.core.parameters import FloatArray

RULES = Rules()
BLOCKS, ROWS, CELLS = 12, 100, 4
EACH = "each cell of its own"
HELD = np.array([False, False, True, True])


def rates(rng: np.random.Generator) -> FloatArray:
    """What a lag of each cell adds, shape (m, cells)."""
    return rng.normal(size=(BLOCKS * ROWS, CELLS))


def judged(seed: int, sizes: tuple[float, ...]) -> tuple[Unnamed, float]:
    """Two cells lag, two are held at zero; what the lags remove."""
    rng = np.random.default_rng([43, seed])
    columns = rates(rng)
    m = len(columns)
    residual = columns @ np.array(sizes) + rng.normal(size=m)
    block = np.repeat(np.arange(BLOCKS), ROWS)
    problem = Problem(
        residual=residual, calibration=np.ones((m, 1)),
        columns=np.empty((m, 0)), signatures=(), block=block,
        output=np.zeros(m, dtype=np.int64), sequence=block, outputs=("fz",), units=("N",),
        noise=np.ones(m), tolerance=np.ones(1), rate_hz=20.0, accepted=columns,
    )  # fmt: skip
    found = against_other_sign(problem, columns, HELD, sign_patterns(BLOCKS, seed))
    return found, float(m * np.sum(np.square(sizes)[~HELD]))


@pytest.mark.parametrize("seed", range(6))
def test_cells_that_are_at_zero_ask_for_nothing(seed: int) -> None:
    found, removed = judged(seed, (0.5, 0.5, 0.0, 0.0))
    assert not found.spoils(removed, RULES)


@pytest.mark.parametrize("seed", range(6))
def test_a_cell_that_leads_spoils_the_lag_of_the_others(seed: int) -> None:
    found, removed = judged(seed, (0.5, 0.5, 0.0, -0.5))
    assert found.left.p < RULES.alpha_form
    assert found.spoils(removed, RULES)


def fitted(effect: str, values: Mapping[str, float]) -> tuple[Refit, Cause]:
    size = TABLE[effect].sizes[0].name
    owners = tuple((cell, (cell,)) for cell in values)
    names = tuple(f"{cell}.{size}" for cell in values)
    model = SimpleNamespace(names=names, values=dict(zip(names, values.values(), strict=True)))
    one = Interval(1.0, 0.9, 1.1)
    signature = Signature(effect, size, EACH, "", owners=owners)
    return cast("Refit", model), Cause(signature, one, 0.001, one, 9, 0.0, (), ())


def held(effect: str, **values: float) -> list[bool]:
    model, cause = fitted(effect, values)
    return [bool(h) for h in held_at_zero(model, [TABLE[effect]], [cause])]


@pytest.mark.parametrize(("converged", "where"), [(False, "left_fl"), (True, EACH)])
def test_sizes_of_every_cell_that_do_not_converge_are_no_answer(
    monkeypatch: pytest.MonkeyPatch, converged: bool, where: str
) -> None:
    """Both leave nothing: only whether the iteration ended differs."""
    cells = ("left_fl", "left_fr")
    model, apart = fitted("dead_zone", dict.fromkeys(cells, 0.1))
    both = SimpleNamespace(
        converged=converged, names=model.names, intervals=(Interval(0.1, 0.09, 0.11),) * 2
    )
    monkeypatch.setattr(by_cell, "refitted_with", lambda *_: both)
    monkeypatch.setattr(by_cell, "white_loss", lambda *_: np.zeros(BLOCKS))
    monkeypatch.setattr(by_cell, "_differs_by_cell", lambda *_: True)
    monkeypatch.setattr(by_cell, "own_place", lambda *_: (EACH, apart.signature.owners))
    subject = SimpleNamespace(
        case=None, table=TABLE, bare=lambda *_: None, without_credit=lambda *_: None
    )
    alone = replace(apart, signature=replace(apart.signature, where="left_fl"))
    best = SimpleNamespace(cause=alone, loss=np.ones(BLOCKS), fitted=None)
    signs = sign_patterns(BLOCKS, 0)
    field = SimpleNamespace(subject=subject, causes=(), model=None, signs=signs, noise=None)
    answer = by_cell.in_each_cell(field, best, RULES)  # type: ignore[arg-type]
    assert answer[0].signature.where == where


def test_only_sizes_of_several_cells_at_a_one_sided_zero_are_held() -> None:
    assert held("sensor_lag", left_fl=0.01, left_fr=0.0, left_rl=1e-9) == [False, True, True]
    assert held("sensor_lag", left_fl=0.0) == [False]
    # a curve may bend either way
    assert held("nonlinearity", left_fl=1e-3, left_fr=0.0) == [False, False]
