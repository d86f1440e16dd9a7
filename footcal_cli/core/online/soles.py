"""How far soles stand from where the joints have them: an error that lasts a stance.

A sole at ``p + δ`` in place of p adds ``F δ`` to the moment of its load F. δ is drawn anew with
each stance, so that what a walk tells of the cells grows with the number of its stances, not with
that of its samples. Noise that decays in time has less power at the frequency of strides than a
shift that lasts a stance: with it gains are stated too surely, and wander with every stance.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from footcal_cli.core.effects.contract import Scope, columns_of
from footcal_cli.core.experiments import walk
from footcal_cli.core.log import Log
from footcal_cli.core.parameters import BoolArray, FloatArray, IntArray


@dataclass(frozen=True)
class Soles:
    """Shifts of soles, ahead and left of each foot in turn.

    Parameters
    ----------
    columns
        Change of the totals' error per metre of each shift, N or Nm per m, (u, totals, 2 feet).
    renewed
        Updates in which each is drawn anew, (u, 2 feet).
    """

    columns: FloatArray
    renewed: BoolArray

    @classmethod
    def none(cls, updates: int, totals: int) -> Soles:
        """No such error."""
        return cls(np.zeros((updates, totals, 0)), np.zeros((updates, 0), dtype=bool))

    @classmethod
    def of(cls, log: Log, size: int) -> Soles:
        """From the loads of a log in newtons, `size` samples per update.

        Shifts are drawn anew while the foot is in the air, where they change nothing.
        """
        feet, updates = columns_of(Scope.FOOT, log.channels), len(log) // size
        used = slice(0, updates * size)
        columns = np.zeros((updates, len(walk.CELL_TOTALS), 2 * len(feet)))
        for foot, cells in enumerate(feet):
            load = np.nan_to_num(log.readings[used][:, cells].sum(axis=1))
            load = load.reshape(-1, size).mean(axis=1)
            columns[:, 1, 2 * foot + 1], columns[:, 2, 2 * foot] = load, -load
        in_air = (log.known["contact"][used] == 0.0).reshape(updates, size, -1).any(axis=1)
        return cls(columns, np.repeat(in_air, 2, axis=1))

    def chosen(self, cut: slice | IntArray) -> Soles:
        """Those of some updates, in their order."""
        return Soles(self.columns[cut], self.renewed[cut])

    def within(self, filtered: Callable[[FloatArray], FloatArray]) -> Soles:
        """In the band of a filter: it smears loads, so a shift lasts to the middle of the swing."""
        middles = np.zeros(self.renewed.shape, dtype=bool)
        for in_air, middle in zip(self.renewed.T, middles.T, strict=True):
            edges = np.flatnonzero(np.diff(np.pad(in_air.astype(int), 1)))
            middle[(edges[::2] + edges[1::2]) // 2] = True
        return Soles(filtered(self.columns), middles)
