"""The smoothing of a state estimator, against the closed form of a filter that people use."""

from __future__ import annotations

import numpy as np
import pytest

from footcal_cli.core.effects.transport import SMOOTHING
from tests.contract.logs import cell_log

INNER = slice(40, -40)


@pytest.mark.parametrize("frequency_hz", [1.0, 2.0, 4.0])
def test_a_moving_average_is_its_two_moments(frequency_hz: float) -> None:
    """A mean over w multiplies a sine of ω by sin(ωw/2)/(ωw/2); its moments are w²/12 and w⁴/80."""
    log, window_s = cell_log(), 0.12
    omega = 2.0 * np.pi * frequency_hz
    sine = np.zeros_like(log.known["com_acc_mps2"])
    sine[:, 0] = np.sin(omega * log.time_s)
    theta = {
        "smoothing": np.array([window_s**2 / 12.0]),
        "smoothing_fourth": np.array([window_s**4 / 80.0]),
    }
    smooth, _ = SMOOTHING.apply(log.with_known(com_acc_mps2=sine), theta, None)
    share = np.sinc(frequency_hz * window_s)
    found = smooth.known["com_acc_mps2"][INNER, 0]
    assert np.abs(found - share * sine[INNER, 0]).max() < 0.015
