"""What a set of hanging orientations cannot show, in words."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from footcal_cli.core.effects.six_axis_beliefs import HANG_TILT
from footcal_cli.core.hang.model import DRIFT, WARMTH, HangModel
from footcal_cli.core.inference.fit import Fit
from footcal_cli.core.parameters import FloatArray, Status

_DISTINCT = np.sin(np.deg2rad(20.0))
_POOR_STEPS = 0.5
_NAMED_SHARE = 0.3
_MAX_DIRECTIONS = 8

_HELD = ("wrist", "hand", "arm", "tool", "gripper", "flange")


def hanging_thing(orders: Mapping[str, int]) -> str:
    """``tool`` or ``leg``: the word for what hangs below the transducers.

    Parameters
    ----------
    orders
        Name of each transducer -> harmonics of its shaft angle (0: nothing turns below it).
    """
    turns = any(orders.values())
    held = all(any(word in name.lower() for word in _HELD) for name in orders)
    return "leg" if turns or (len(orders) > 1 and not held) else "tool"


def hang_gaps(model: HangModel, fit: Fit) -> tuple[str, ...]:
    """Sentences on what stays unknown, and which orientation would show it.

    First what geometry says of the nominal orientations, then every direction of the parameter
    space that the data see worse than half a typical size (see `weak_directions`).
    """
    direction = model.nominal_dir_t
    sentences = []
    along = np.linalg.svd(direction, compute_uv=False)
    spread = np.linalg.norm(direction - direction[0], axis=1).max()
    if spread < _DISTINCT:
        sentences.append(
            f"{model.leg}: one orientation only: weight and force offset along gravity are seen "
            "as their sum, CoM and torque offset likewise; hang the robot the other way up too"
        )
    elif along.size < 2 or along[1] < _DISTINCT:
        axis = _axis_word(direction[0])
        sentences.append(
            f"{model.leg}: all logs hang along {axis}: the CoM along {axis} makes no torque "
            "and is unknown (one-dimensional null space per harmonic); hang along a second axis"
        )
    elif not _has_opposites(direction) and direction.shape[0] <= 3:
        sentences.append(
            f"{model.leg}: no opposite pair of orientations: offset and weight are distinguished "
            f"by "
            "the change of direction alone and are several times less exact than with pairs"
        )
    sentences += [f"{model.leg}: not seen: {words}" for words in weak_directions(fit)]
    return tuple(sentences)


def weak_directions(fit: Fit) -> tuple[str, ...]:
    """Combinations of parameters that the data leave open, each as ``0.7 a − 0.7 b``.

    In units of each parameter's typical size; only parameters with a share of at least 0.3.
    Of the Jacobian ``J = Q R`` only R is decomposed: its singular values and directions are J's,
    and its size is that of the parameters, however many rows a log has.
    """
    names = fit.estimates.names
    scaled = fit.jacobian * np.array([typical_size(name) for name in names])
    _, singular, right = np.linalg.svd(np.linalg.qr(scaled, mode="r"), full_matrices=True)
    strength = np.zeros(right.shape[0])
    strength[: singular.size] = singular
    weak = right[strength < 1.0 / _POOR_STEPS]
    return tuple(_combination(row, names) for row in weak[:_MAX_DIRECTIONS])


def with_unseen(fit: Fit) -> Fit:
    """The fit with every parameter whose sd exceeds a typical size marked as not observable."""
    estimates = fit.estimates
    status = tuple(
        Status.PRIOR_KEPT if sd > typical_size(name) and status is Status.ESTIMATED else status
        for name, sd, status in zip(estimates.names, estimates.sd, estimates.status, strict=True)
    )
    return replace(fit, estimates=replace(estimates, status=status))


def typical_size(name: str) -> float:
    """A typical size: 1 N, 0.1 Nm, 1 cm, 1 degree; ten of them per degC or hour would be much."""
    quantity = name.split(".", 1)[-1]
    if quantity.startswith("com_"):
        return 0.01
    if quantity.startswith((HANG_TILT.name, "mount_rot")):
        return 0.02
    size = 0.1 if quantity.endswith(("_tx", "_ty", "_tz")) else 1.0
    if quantity.startswith(WARMTH):
        return 0.1 * size
    return size / 1000.0 if quantity.startswith(DRIFT) else size


def _combination(row: FloatArray, names: tuple[str, ...]) -> str:
    order = np.argsort(-np.abs(row).round(6), kind="stable")  # equal shares stay in their order
    chosen = [i for i in order if abs(row[i]) >= _NAMED_SHARE] or [order[0]]
    sign = np.sign(row[chosen[0]])
    parts = [
        f"{'−' if sign * row[i] < 0 else '+'} {abs(row[i]):.1f} {names[i].split('.', 1)[-1]}"
        for i in chosen
    ]
    return " ".join(parts).removeprefix("+ ")


def _axis_word(direction: FloatArray) -> str:
    axis = int(np.argmax(np.abs(direction)))
    return "xyz"[axis] if abs(direction[axis]) > 1.0 - 1e-3 else "that one direction"


def _has_opposites(direction: FloatArray) -> bool:
    return bool((direction @ direction.T).min() < -np.cos(np.arcsin(_DISTINCT)))
