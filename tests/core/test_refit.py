"""How far a refit goes where its steps creep along a line or swing about its end."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from footcal_cli.core.effects import TABLE
from footcal_cli.core.inference.freed import Freed, around, seen
from footcal_cli.core.inference.refit import _Step
from footcal_cli.core.parameters import FloatArray

END, SPREAD = np.array([0.3, -2.0]), np.array([0.01, 0.5])


def step(at: FloatArray, slope: float) -> _Step:
    """``s(θ) = a (θ* − θ)``: it creeps where a is small, and swings away where a is above 2."""
    return _Step(slope * (END - at), SPREAD, np.arange(2))


@pytest.mark.parametrize("slope", [0.2, 1.0, 1.95, 2.8])
@pytest.mark.parametrize("share", [1.0, 0.3])
def test_the_second_step_along_a_line_ends_where_none_leads_away(
    slope: float, share: float
) -> None:
    begin = END + np.array([0.05, 1.0])
    first = step(begin, slope)
    there = begin + share * first.size
    second = step(there, slope)
    if slope * share != 1.0:
        assert abs(second.cosine(first)) == pytest.approx(1.0)
    assert there + second.relaxed(first, share) * second.size == pytest.approx(END)


def test_the_length_of_a_step_is_in_standard_errors() -> None:
    one = step(END - SPREAD * np.array([3.0, 4.0]), 1.0)
    assert one.length() == pytest.approx(5.0)
    assert one.furthest() == pytest.approx(4.0)
    assert one.length(_Step(one.size, 2.0 * SPREAD, one.free)) == pytest.approx(2.5)


@pytest.mark.parametrize("value", [0.05, 4.0, 200.0, 201.0, 400.0])
def test_a_derivative_has_two_ends_wherever_a_shape_stands(value: float) -> None:
    """A dead zone of 0.4 of a load of 502 N ended with a division by nothing."""
    width = next(p for p in TABLE["dead_zone"].parameters if p.name == "dead_zone_width")
    low, high = around(value, Freed("cell.dead_zone_width", width, 0.08, named=False))
    assert 0.08 - 1e-9 < high - low < 0.16 + 1e-9
    assert low <= value <= high
    assert low >= width.lower


@pytest.mark.parametrize(("named_n", "freed"), [(1.0, 1), (40.0, 3)])
def test_what_jumps_by_forty_usual_sizes_along_one_axis_may_along_another(
    named_n: float, freed: int
) -> None:
    """Rows whose noise is ten times a usual change of an offset, of a robot of 80 kg."""
    effect, at = TABLE["offset_change"], np.repeat([0.0, 1.0], 20)
    columns = np.kron(np.eye(3), at[:, None]) / 10.0
    items = [
        Freed(f"left.{p.name}", p, 0.02, named=p.name.endswith("_fz"))
        for p in effect.sizes if "_f" in p.name[-3:]
    ]  # fmt: skip
    values = {item.name: named_n if item.named else 0.0 for item in items}
    problem = SimpleNamespace(
        calibration=np.kron(np.eye(3), np.ones((40, 1))),
        known=None,
        settings=None,
        residual=np.zeros(len(columns)),
    )
    kept = seen(items, problem, columns, values)  # type: ignore[arg-type]
    assert len(kept) == freed
