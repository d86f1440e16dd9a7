"""What figures of long logs draw."""

from __future__ import annotations

import numpy as np
import pytest

from footcal_cli.core.signals import peaks_kept
from footcal_cli.plots.style import MOST_POINTS


@pytest.mark.parametrize("size", [1, 3999, 4001, 100_003])
def test_a_long_series_is_drawn_by_few_points_and_keeps_its_peaks(size: int) -> None:
    values = np.sin(np.arange(size) / 50.0)
    values[size // 3], values[size // 2] = 9.0, -9.0
    values[size // 5] = np.nan if size > 5 else 0.0
    drawn = peaks_kept(values, MOST_POINTS)
    assert drawn.size <= MOST_POINTS
    assert (np.diff(drawn) > 0).all()
    shown = values[drawn]
    assert np.nanmax(shown) == np.nanmax(values)
    assert np.nanmin(shown) == np.nanmin(values)
    if size <= MOST_POINTS:
        assert drawn.size == size
