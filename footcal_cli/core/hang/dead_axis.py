"""An axis of a transducer that what hangs on it does not move.

Room: core, hang; asked by its sheet and by the hanging case of a diagnosis.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from footcal_cli.core.effects.calibration import AXES
from footcal_cli.core.hang.runs import HangRun
from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.quality import Finding
from footcal_cli.core.spatial import skew

_FEWEST = 8
"""Attitudes asked for."""
_SHOWN = 2.0
"""Times the scatter of all other axes about one weight that the axis should move by (sd)."""
_FOLLOWS = 0.3
"""Share of what it should read from which an axis follows; a gain is off by less than the rest."""


def dead_axes(runs: Mapping[str, Sequence[HangRun]], thing: str) -> list[Finding]:
    """Find axes that stand still while one weight at one place moves all others as it should.

    Without axis k: ``f = m g d + o`` and ``τ = r × (m g d) + t`` by least squares; the slope of
    what axis k reads over what it should read is 1 where it works.

    Parameters
    ----------
    runs
        Per transducer, one of each attitude.
    thing
        What hangs there, in words.
    """
    found = []
    for leg, own in runs.items():
        if len(own) < _FEWEST:
            continue
        way = np.array([run.nominal_dir_t for run in own])
        wrench = np.array([run.wrench.mean(axis=0) for run in own])
        for axis, name in enumerate(AXES):
            shown, asked = _shown(way, wrench, axis)
            if shown < _FOLLOWS and asked:
                unit = "N" if axis < 3 else "Nm"
                found.append(
                    Finding(
                        "dead_axis", "alarm", f"{leg}.{name}",
                        f"it moves by {np.std(wrench[:, axis]):.2g} {unit} (sd) from attitude to "
                        f"attitude, where the {thing} that the other axes feel should move it by "
                        f"{asked:.2g} {unit}",
                        "check this channel's bridge, plug and column; readings without it are no "
                        "wrench",
                    )
                )  # fmt: skip
    return found


def _shown(way: FloatArray, wrench: FloatArray, axis: int) -> tuple[float, float]:
    """Upper end of the slope of an axis over what it should read, and that's sd where it is clear.

    Zero for the sd where the others scatter too much to say, or the axis should hardly move.
    """
    n, force = len(way), np.arange(3)
    others = force[force != axis]
    d = way - way.mean(axis=0)
    f = wrench[:, :3] - wrench[:, :3].mean(axis=0)
    weight = float(np.sum(d[:, others] * f[:, others]) / np.sum(d[:, others] ** 2))
    felt = weight * d
    # τ = r × F = −[F]× r, centred
    lever = -skew(felt)
    torque = wrench[:, 3:] - wrench[:, 3:].mean(axis=0)
    mine = force[force + 3 != axis]
    rows = lever[:, mine].reshape(-1, 3)
    place, *_ = np.linalg.lstsq(rows, torque[:, mine].reshape(-1), rcond=None)
    should = np.column_stack([felt, lever @ place])
    seen = np.column_stack([f, torque])
    kin = [k for k in (range(3) if axis < 3 else range(3, 6)) if k != axis]
    scatter = float(np.sqrt(np.mean((seen[:, kin] - should[:, kin]) ** 2)))
    asked = float(np.std(should[:, axis]))
    if asked < _SHOWN * max(scatter, 1e-12):
        return 1.0, 0.0
    own = should[:, axis]
    slope = float(own @ seen[:, axis] / (own @ own))
    left = seen[:, axis] - slope * own
    sd = float(np.sqrt(left @ left / max(n - 2, 1) / (own @ own)))
    return abs(slope) + 2.0 * sd, asked
