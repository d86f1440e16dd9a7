"""How transducers are turned against the body whose attitude a log holds, by the weight they carry.

What hangs on a transducer of a robot pulls with ``f = w Rᵀ g + b``: `g` the direction of gravity
in the body, `R` from the transducer to the body. Over several attitudes the best rotation is that
of Kabsch (1976); of the ways to read the attitude, the one that explains most is taken.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.spatial import rotation_log, rpy_of_rotation
from footcal_cli.sniff.attitudes import (
    EXPLAINED,
    REACTS,
    Attitude,
    AttitudeReading,
    readings_of,
    turns,
    upside_down,
)
from footcal_cli.sniff.drawn_turns import AXES_NEAR, nominal
from footcal_cli.sniff.guesses import FileGuess

_CARRIED = 0.3
"""Share of what changes in the forces' sum that the weight leaves, of a robot that stands."""
_MOST = 4000
_LEAST_TURNED = 30
_ONE_WEIGHT, _FAR_TURNED = 0.1, 0.5
"""How far one weight's size scatters by what its components do, and these by the weight."""
_FITTED = 7
"""A rotation, a weight and three offsets."""


@dataclass(frozen=True)
class Mounts:
    """Transducers that hang on one body.

    Parameters
    ----------
    attitude
        How the log says which way gravity pulls on the body.
    rotation
        Transducer to body by name, shape (3, 3); along axes or in whole degrees.
    hang
        Whether most transducers carry one weight in every attitude; None where the body hardly
        turns.
    turns_about
        Axis of the body about which each turns with its leg, where they do.
    """

    attitude: Attitude
    rotation: Mapping[str, FloatArray]
    hang: bool | None
    turns_about: Mapping[str, str] = field(default_factory=dict)

    def rpy_rad(self, name: str) -> tuple[float, float, float]:
        """Roll, pitch and yaw of a transducer's mounting, as a recipe has them."""
        roll, pitch, yaw = (
            round(float(angle), 4) + 0.0 for angle in rpy_of_rotation(self.rotation[name])
        )
        return roll, pitch, yaw


def mounts_of(file: FileGuess, forces: Mapping[str, FloatArray]) -> Mounts | None:
    """Attitude of the body and mounting of its transducers; None without an attitude.

    Parameters
    ----------
    file
        The log.
    forces
        Of each transducer, shape (n, 3).
    """
    candidates = readings_of(file)
    if not candidates:
        return None
    first = candidates[0]
    hung = [hung_on(one.gravity, forces) for one in candidates]
    left = [one.left for one in hung]
    at = int(np.argmin(left))
    if left[0] < 2 * left[at] + 1e-4:
        at = 0
    # of most: one leg with a broken axis does not make a robot that hangs one that stands
    if not hung[at].explained:
        return Mounts(Attitude(_standing(candidates, forces).entries, explains=False), {}, False)
    if not turns(first.gravity):
        return Mounts(Attitude(first.entries), {}, None)
    reacts = hung[at].reacts
    chosen: AttitudeReading = candidates[at]
    warnings = (f"{chosen.said}: so the forces are the weights of the legs",) if at else ()
    if reacts and (why := upside_down(file, chosen)):
        reacts, chosen = False, chosen.upside_down
        warnings = (*warnings, f"{why}: so the legs have weight")
    elif reacts:
        warnings = (*warnings, REACTS.format("the transducers read", "them", "their"))
    attitude = Attitude(chosen.entries, warnings, reacts, True, chosen.world_up)
    return Mounts(attitude, hung[at].rotation, True)


def one_weight_each(forces: Mapping[str, FloatArray]) -> bool:
    """Whether each transducer carries one weight, however it is turned: forces lie on a sphere.

    ``|f|² = 2 b·f + c`` for offsets `b`, where c is ``w² − b²`` of a weight `w`; ``|f − b|``
    scatters by a small share of what the forces do. It must be turned far enough to tell.
    """
    return bool(forces) and all(_on_a_sphere(force) for force in forces.values())


def _on_a_sphere(force: FloatArray) -> bool:
    good = np.flatnonzero(np.isfinite(force).all(axis=1))
    f = force[good[:: max(1, good.size // _MOST)]]
    if len(f) < _LEAST_TURNED:
        return False
    design = np.column_stack([2.0 * f, np.ones(len(f))])
    *centre, level = np.linalg.lstsq(design, (f * f).sum(axis=1), rcond=1e-3)[0]
    radius = np.sqrt(max(level + float(np.square(centre).sum()), 0.0))
    length = np.linalg.norm(f - centre, axis=1)
    spread = np.sqrt(f.var(axis=0).sum())
    return bool(length.std() < _ONE_WEIGHT * spread and _FAR_TURNED * radius < spread)


def _standing(
    candidates: Sequence[AttitudeReading], forces: Mapping[str, FloatArray]
) -> AttitudeReading:
    """The reading in which transducers along the body's axes carry its weight together.

    The first where none is much better: they may be turned in the body.
    """
    total = np.sum([*forces.values()], axis=0)
    left = []
    for one in candidates:
        good = np.isfinite(total).all(axis=1) & np.isfinite(one.gravity).all(axis=1)
        if not good.any():
            return candidates[0]
        f, g = (v[good] - v[good].mean(axis=0) for v in (total, one.gravity))
        size, spread = float((f * f).sum()), float((g * g).sum())
        slope = float((f * g).sum()) / spread if spread else 0.0
        rest = float(((f - slope * g) ** 2).sum())
        left.append(rest / size if size > 0.0 > slope else 1.0)
    at = int(np.argmin(left))
    return candidates[at] if left[at] < min(_CARRIED, left[0] / 3) else candidates[0]


@dataclass(frozen=True)
class HungBody:
    """Transducers that hang on one body, in one reading of its attitude.

    Parameters
    ----------
    rotation
        Transducer to body by name, shape (3, 3); along axes or in whole degrees.
    reacts
        Whether they read the opposite of what pulls on them.
    left, explained
        Mean share of the forces' variance that is left, and whether most have little left.
    either
        Whether the attitudes lie in a plane, so that other rotations fit the opposite sign as well.
    """

    rotation: Mapping[str, FloatArray]
    reacts: bool
    left: float
    explained: bool
    either: bool


def hung_on(gravity_b: FloatArray, forces: Mapping[str, FloatArray]) -> HungBody:
    """Rotations and the one sign of all transducers, the plainest of those that fit.

    A plane of attitudes fits both signs: that with the smaller rotations is taken, and the weight
    pulls as it should where they are alike.
    """
    fits = [{name: _kabsch(gravity_b, f)[i] for name, f in forces.items()} for i in (0, 1)]
    left = [float(np.median([fit.left for fit in own.values()])) for own in fits]
    found = [{name: nominal(fit.rotation) for name, fit in own.items()} for own in fits]
    either = max(left) < 2 * min(left) + 1e-4 and max(left) < EXPLAINED
    turned = [float(np.mean([_angle(turn) for turn in own.values()])) for own in found]
    plainer = turned[1] < turned[0] - AXES_NEAR
    reacts = bool(plainer if either else left[1] < 0.5 * left[0])
    chosen = fits[reacts]
    mean = float(np.mean([fit.left for fit in chosen.values()]))
    return HungBody(found[reacts], reacts, mean, left[reacts] < EXPLAINED, either)


@dataclass(frozen=True)
class _Fit:
    """Rotation transducer to body, share of the variance that is left."""

    rotation: FloatArray
    left: float


def _kabsch(gravity_b: FloatArray, force: FloatArray) -> tuple[_Fit, _Fit]:
    """``f = w Rᵀ g + b`` and ``f = −w Rᵀ g + b`` in least squares, `R` a rotation."""
    good = np.flatnonzero(np.isfinite(force).all(axis=1) & np.isfinite(gravity_b).all(axis=1))
    good = good[:: max(1, good.size // _MOST)]
    if good.size < 4:
        return _Fit(np.eye(3), 1.0), _Fit(np.eye(3), 1.0)
    f, g = force[good] - force[good].mean(axis=0), gravity_b[good] - gravity_b[good].mean(axis=0)
    whole = float((f * f).sum() * (g * g).sum())
    if whole == 0.0:
        return _Fit(np.eye(3), 1.0), _Fit(np.eye(3), 1.0)
    u, size, vt = np.linalg.svd(g.T @ f)
    mirrored = np.linalg.det(u @ vt) < 0
    least = np.array([1.0, 1.0, -1.0 if mirrored else 1.0])
    most = np.array([1.0, 1.0, 1.0 if mirrored else -1.0])
    # a few attitudes are explained by any rotation: each number that is fitted counts
    by_chance = 3 * good.size / (3 * good.size - _FITTED)
    pulls, pushes = (by_chance * (1.0 - float(size @ d) ** 2 / whole) for d in (least, most))
    return _Fit((u * least) @ vt, pulls), _Fit(-(u * most) @ vt, pushes)


def _angle(rotation: FloatArray) -> float:
    return float(np.linalg.norm(rotation_log(rotation)))
