"""Effects that are removed column by column, and derivatives that remove no column twice."""

from __future__ import annotations

import numpy as np
import pytest

from footcal_cli.core.chain import Seen, chain_of, link
from footcal_cli.core.effects import TABLE
from footcal_cli.core.effects.contract import Effect
from tests.contract.logs import log_for, typical

BY_COLUMN = [effect for effect in TABLE.values() if effect.by_column]


@pytest.mark.parametrize("effect", BY_COLUMN, ids=lambda effect: effect.name)
def test_a_column_is_the_same_whatever_the_others_are(effect: Effect) -> None:
    log = log_for(effect)
    theta = typical(effect, len(log.channels))
    whole = effect.remove(log, theta, None)[0].readings
    rng = np.random.default_rng(1)
    other = log.with_readings(log.readings + rng.standard_normal(log.readings.shape))
    other.readings[:, 2] = log.readings[:, 2]
    np.testing.assert_array_equal(effect.remove(other, theta, None)[0].readings[:, 2], whole[:, 2])


@pytest.mark.parametrize("effect", BY_COLUMN, ids=lambda effect: effect.name)
def test_what_was_seen_changes_nothing(effect: Effect) -> None:
    """One channel moves at a time, then two, then a calibration before it, then all come back."""
    log = log_for(effect)
    chain = chain_of([link(TABLE["scale_bias"], log.channels), link(effect, log.channels)])
    start = dict.fromkeys((f"{c}.scale" for c in log.channels), 1.0)
    for name, theta in typical(effect, len(log.channels)).items():
        start |= {f"{c}.{name}": float(v) for c, v in zip(log.channels, theta, strict=True)}
    first, second = (f"{c}.{effect.size.name}" for c in log.channels[:2])
    seen = Seen()
    for change in (
        {},
        {first: 1.2 * start[first]},
        {second: 1.1 * start[second]},
        {f"{log.channels[3]}.scale": 1.01},
        {first: 0.0},
        {},
    ):
        values = {**start, **change}
        found = chain.truth(log, values, seen).readings
        np.testing.assert_array_equal(found, chain.remove(log, values)[0].readings)
