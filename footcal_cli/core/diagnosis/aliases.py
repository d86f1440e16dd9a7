"""Effects that these data cannot tell from an accepted one, known before any residual is seen."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from footcal_cli.core.diagnosis.library import Library
from footcal_cli.core.effects import TABLE
from footcal_cli.core.inference.linear import scaled_inverse
from footcal_cli.core.inference.problem import Signature
from footcal_cli.core.parameters import FloatArray, IntArray


def aliases(
    lib: Library, signature: Signature, sizes: Mapping[str, float]
) -> list[tuple[Signature, float, float]]:
    """Other effects whose visible part can copy that of a fitted effect, the nearest first.

    ``cos = |P_j g̃| / |g̃|``: g̃ what the fitted effect leaves after calibration, P_j the projection
    on what another effect leaves, all its axes together. An offset in any direction is compared
    with an offset in any direction.

    Parameters
    ----------
    lib
        All candidates; its calibration holds what was accepted before.
    signature
        The fitted effect.
    sizes
        Fitted value of each of its size parameters.

    Returns
    -------
    signature, size and cos of each effect where it comes nearest; copies of impossible size are
    left out.
    """
    best: dict[str, tuple[Signature, float, float]] = {}
    mine, weights = _fitted(lib, signature, sizes)
    for members in _groups(lib):
        other = lib.problem.signatures[members[0]]
        if other.effect == signature.effect:
            continue
        cos, needed = _copy(lib.products, mine, weights, members)
        possible = all(
            lib.problem.signatures[i].lower <= size <= lib.problem.signatures[i].upper
            for i, size in zip(members, needed, strict=True)
        )
        if possible and cos > best.get(other.effect, (other, 0.0, 0.0))[2]:
            largest = int(np.argmax(needed**2 * np.diag(lib.products)[members]))
            best[other.effect] = (
                lib.problem.signatures[members[largest]], float(needed[largest]), cos,
            )  # fmt: skip
    return sorted(best.values(), key=lambda item: -item[2])


def copied(
    lib: Library, signature: Signature, sizes: Mapping[str, float], rival: Signature
) -> tuple[float, dict[str, float]]:
    """How nearly a rival in its place copies a fitted effect, and each of its sizes that does.

    Parameters
    ----------
    lib, signature, sizes
        As in `aliases`.
    rival
        Any axis of it.
    """
    signatures = lib.problem.signatures
    place, mine = _place(rival), _fitted(lib, signature, sizes)
    groups = [members for members in _groups(lib) if _place(signatures[members[0]]) == place]
    if not groups:
        return 0.0, {}
    copies = [(*_copy(lib.products, *mine, members), members) for members in groups]
    cos, needed, members = max(copies, key=lambda copy: copy[0])
    return cos, {
        signatures[i].parameter: float(size) for i, size in zip(members, needed, strict=True)
    }


def _fitted(
    lib: Library, signature: Signature, sizes: Mapping[str, float]
) -> tuple[IntArray, FloatArray]:
    """Columns of a fitted effect in its place, and the size of each."""
    # what a refit made of a cause may stand where the linear test could not look
    signatures, place = lib.problem.signatures, _place(signature)
    mine: dict[str, list[int]] = {}
    for i, s in enumerate(signatures):
        if _place(s) == place:
            mine.setdefault(s.parameter, []).append(i)
    weights = np.array([sizes.get(name, 0.0) for name in mine])
    effect = TABLE.get(signature.effect)
    far = {} if effect is None else {p.name: p.far for p in effect.sizes}
    columns = []
    for (name, own), size in zip(mine.items(), weights, strict=True):
        # one column for each change at which a size that acts far from linearly was taken
        taken_at = np.array([0.0, *far.get(name, ())])[: len(own)]
        columns.append(own[int(np.argmin(np.abs(taken_at - size)))])
    return np.array(columns, dtype=np.int64), weights


def _copy(
    seen: FloatArray, mine: IntArray, weights: FloatArray, members: IntArray
) -> tuple[float, FloatArray]:
    """Cos and sizes of the copy that some axes of another effect make of a fitted one."""
    own = float(weights @ seen[np.ix_(mine, mine)] @ weights)
    if own <= 0.0:
        return 0.0, np.zeros(members.size)
    cross = seen[np.ix_(members, mine)] @ weights
    needed = _solved(seen[np.ix_(members, members)], cross)
    return float(np.sqrt(np.clip(cross @ needed / own, 0.0, 1.0))), needed


def _place(signature: Signature) -> tuple[object, ...]:
    return signature.effect, signature.where, signature.shape


def _groups(lib: Library) -> list[IntArray]:
    """Testable candidates of one effect, place and shape, the axes of one offset.

    Of a size with several columns each is of a group of its own: one is how it acts at one size.
    """
    found: dict[tuple[object, ...], list[int]] = {}
    seen: dict[tuple[object, ...], int] = {}
    for i, signature in enumerate(lib.problem.signatures):
        key = (_place(signature), signature.parameter)
        seen[key] = seen.get(key, -1) + 1
        if lib.testable[i]:
            found.setdefault((_place(signature), seen[key]), []).append(i)
    return [np.array(members, dtype=np.int64) for members in found.values()]


def _solved(square: FloatArray, target: FloatArray) -> FloatArray:
    """Least squares of scaled columns; an axis that hardly shows is not used."""
    return np.asarray(scaled_inverse(square, 1e-6) @ target)
