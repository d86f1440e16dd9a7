r"""Whether files of six axes that hang are of one transducer each: by what their forces are off by.

Room: sniff; asked by file_names. Whatever the attitude, a transducer with the weight :math:`w`
below it feels :math:`|f - b| = w`, so that :math:`2 b \cdot f + (w^2 - |b|^2) = |f|^2` is linear.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from footcal_cli.core.parameters import FloatArray
from footcal_cli.sniff.file_loads import as_legs
from footcal_cli.sniff.groups import wrenches
from footcal_cli.sniff.guesses import FileGuess, numbers_of
from footcal_cli.sniff.numbered import numbered

_TURNS = 0.15
"""How far forces go in each of two directions, as a share of the largest: a transducer turns."""
_APART = 4.0
"""Times the squared error of a sphere for each file that one for all of them leaves at least."""
_LEAST_ROWS = 12


def legs_by_offsets(group: Sequence[FileGuess], words: Sequence[str]) -> dict[str, str]:
    """Word of a file's name -> leg; empty where one transducer may have been in all files.

    Parameters
    ----------
    words
        What tells the files' names apart.
    """
    forces = [_forces(file) for file in group]
    if len(group) < 2 or any(f is None or not _turns(f) for f in forces):
        return {}
    known = [f for f in forces if f is not None]
    alone = sum(_left(f) for f in known)
    if _left(np.concatenate(known)) < _APART * alone or not all(w.isalnum() for w in words):
        return {}
    return as_legs(words)


def _forces(file: FileGuess) -> FloatArray | None:
    six = list(wrenches(numbered(file)).values())
    if len(six) != 1 or file.of("load", "label", "orientation"):
        return None
    force = np.column_stack([numbers_of(six[0][axis]) for axis in ("fx", "fy", "fz")])
    force = force[np.isfinite(force).all(axis=1)]
    return force if len(force) >= _LEAST_ROWS else None


def _turns(force: FloatArray) -> bool:
    size = np.linalg.svd(force - force.mean(axis=0), compute_uv=False) / np.sqrt(len(force))
    return bool(size[1] > _TURNS * np.linalg.norm(force, axis=1).max())


def _left(force: FloatArray) -> float:
    """Squared error of the sphere that lies closest, in units of N⁴."""
    target = (force**2).sum(axis=1)
    columns = np.column_stack([2.0 * force, np.ones(len(force))])
    left = target - columns @ np.linalg.lstsq(columns, target, rcond=None)[0]
    return float(left @ left)
