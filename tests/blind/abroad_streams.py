"""What is wrong with a body's stream whatever the robot stands on: late, or averaged."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pandas as pd

from tests.blind.world import Rng


def lateness(rng: Rng) -> dict[str, Any]:
    """A stream's delay and what the recipe says of it, 30 to 100 ms apart."""
    more = float(rng.choice([-1.0, 1.0]) * rng.uniform(0.03, 0.1))
    delay = float(rng.uniform(0.11, 0.13)) if more > 0 else float(rng.uniform(0.0, 0.02))
    return {"delay_s": delay, "stated_delay_s": delay - more}


def averaged(rng: Rng) -> Callable[[pd.DataFrame], pd.DataFrame]:
    """What was differentiated is the mean of the last samples; positions are not averaged."""
    window_s = rng.uniform(0.05, 0.11)

    def changed(body: pd.DataFrame) -> pd.DataFrame:
        samples = round(window_s / float(np.median(np.diff(body["time_s"]))))
        for name in body.columns[body.columns.str.match("com_acc|angmom_rate")]:
            body[name] = body[name].rolling(samples, min_periods=1).mean()
        return body

    return changed
