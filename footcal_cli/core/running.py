"""What a series too long to be held was like: median, largest value, share above a load."""

from __future__ import annotations

import numpy as np

from footcal_cli.core.parameters import FloatArray

_MOST_KEPT = 2**20
"""Values from which a median is taken; of longer series every second, fourth …"""


class Seen:
    """A series of which so many values are kept as its median needs.

    Parameters
    ----------
    least
        From which value on it counts as loaded.
    """

    def __init__(self, least: float) -> None:
        self.least = least
        self.kept = np.zeros(0)
        self.every, self.count, self.loaded, self.largest = 1, 0, 0, -np.inf

    def add(self, values: FloatArray) -> None:
        """Take in the next values, shape (n,)."""
        chosen = values[(-self.count) % self.every :: self.every]
        self.kept = np.concatenate([self.kept, chosen])
        while self.kept.size > _MOST_KEPT:
            self.kept, self.every = self.kept[::2], 2 * self.every
        self.count += values.size
        self.loaded += int(np.sum(values > self.least))
        self.largest = max(self.largest, float(np.nanmax(values, initial=-np.inf)))

    @property
    def median(self) -> float:
        """Of all that were kept."""
        known = self.kept[np.isfinite(self.kept)]
        return float(np.median(known)) if known.size else np.nan
