"""A descent on a cost that is known less exactly than its gradient."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

from footcal_cli.core.inference.descent import descend
from footcal_cli.core.parameters import FloatArray

LOWEST: FloatArray = np.array([0.7, -0.2])


@dataclass(frozen=True)
class Bowl:
    """``1000 + Σ x² / 2 + x⁴ / 4`` about its lowest point; `lost` is what rounding adds."""

    at: FloatArray
    lost: float

    @property
    def cost(self) -> float:
        x = self.at - LOWEST
        return float(1000.0 + np.sum(0.5 * x**2 + 0.25 * x**4) + self.lost)

    @property
    def gradient(self) -> FloatArray:
        x = self.at - LOWEST
        return np.asarray(x + x**3)

    def hessian(self) -> FloatArray:
        return np.diag(1.0 + 3.0 * (self.at - LOWEST) ** 2)


@pytest.mark.parametrize("rounding", [0.0, 1e-9, 1e-8])
def test_what_rounding_hides_is_no_reason_to_try_shorter_steps(rounding: float) -> None:
    """Every new point looks worse by the rounding of the cost than the one before it."""
    seen: list[float] = []

    def at(point: FloatArray) -> Bowl:
        seen.append(0.0)
        return Bowl(point, rounding * len(seen))

    found = descend(at, lambda point, step: point + step, np.array([2.0, 1.0]))
    assert found.converged
    assert len(seen) <= 10
    np.testing.assert_allclose(found.point, LOWEST, atol=1e-9)
