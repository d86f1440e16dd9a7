r"""A column that says which of several weights hangs on a transducer: bare, and with a disc.

Room: sniff; asked by six_axis. Whatever the attitude, forces of one weight lie on a sphere about
the offsets,

.. math:: |F|^2 = 2 b \cdot F + c_k, \qquad c_k = (m_k g)^2 - |b|^2 ,

linear in b and in one number for each value k of the column.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from footcal_cli.core.parameters import FloatArray
from footcal_cli.sniff.guesses import ColumnGuess, FileGuess, numbers_of
from footcal_cli.sniff.plan import Entry

_MOST, _FEWEST = 4, 8
"""Values of such a column, and attitudes with each."""
_APART, _LEFT = 0.1, 0.3
"""By which share weights differ, and what one weight leaves to them of its misfit (RMS) at most."""


def tools_of(file: FileGuess, axes: Mapping[str, ColumnGuess]) -> Entry | None:
    """The column whose values are different weights on one transducer; None without one."""
    force = np.column_stack([numbers_of(axes[a]) for a in ("fx", "fy", "fz")])
    for column in file.columns:
        if column.values is None or column.values.size != len(force) or column in axes.values():
            continue
        values, group, count = np.unique(column.values, return_inverse=True, return_counts=True)
        few = 2 <= values.size <= _MOST and count.min() >= _FEWEST
        if few and np.isfinite(values).all() and _weigh_apart(force, group.ravel()):
            return Entry(column, sure="likely", why="another weight hangs on it with each")
    return None


def _weigh_apart(force: FloatArray, group: np.ndarray[tuple[int, ...], np.dtype[np.intp]]) -> bool:
    """Whether groups of forces, shape (n, 3), lie on spheres of radii that clearly differ."""
    good = np.isfinite(force).all(axis=1)
    force, group = force[good], group[good]
    square = np.sum(force**2, axis=1)

    def left(intercepts: FloatArray) -> tuple[float, FloatArray]:
        design = np.column_stack([2.0 * force, intercepts])
        found = np.linalg.lstsq(design, square, rcond=None)[0]
        return float(np.sqrt(np.mean((square - design @ found) ** 2))), found

    one, _ = left(np.ones((len(force), 1)))
    each, found = left(np.eye(int(group.max()) + 1)[group])
    weights = np.sqrt(np.maximum(found[3:] + found[:3] @ found[:3], 0.0))
    return bool(each < _LEFT * one and np.ptp(weights) > _APART * weights.max())
