"""Signatures by differentiating the chain that fits and simulates: one mechanism for all."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.sparse.csgraph import connected_components

from footcal_cli.core.chain import Chain, Link, Seen
from footcal_cli.core.effects import having
from footcal_cli.core.effects.contract import (
    Effect,
    EffectParameter,
    Trait,
    can_carry,
    unit_of,
    units_of,
)
from footcal_cli.core.inference.case import Case, channels_of, residual
from footcal_cli.core.inference.places import carriers, owners_of, places
from footcal_cli.core.inference.problem import Excluded, Problem, Signature
from footcal_cli.core.inference.responses import BESIDE, Responses, ends_of
from footcal_cli.core.inference.shapes import forms_by_unit
from footcal_cli.core.parameters import BoolArray, FloatArray

_DIFFERENCE = 1e-4  # finite-difference step of the calibration, in its own steps
ALIKE = 0.995
"""|cos| from which two shapes of an effect count as one."""
_NOTHING = 1e-6  # RMS change in noise units at a usual size: below it is rounding
_ROUNDING = 1e-9  # of a column's largest part: what is left of a sum that cancels
_CARRIED = 0.3  # RMS change in noise units of a whole swap: below it the axis carries nothing
_PIECE = 128  # rows that are put side by side at once
SWITCHES = having(Trait.SWITCH)
"""Effects that are on or off: differentiated at the swapped readings, a whole one looks like −1."""


@dataclass(frozen=True)
class LibraryColumns:
    """Signatures with their columns, and what could not have one.

    Parameters
    ----------
    columns
        What size one of each adds to the residual, shape (m,).
    """

    signatures: tuple[Signature, ...]
    columns: tuple[FloatArray, ...]
    excluded: tuple[Excluded, ...]

    def asked_of(self, problem: Problem, without: Collection[tuple[str, str]] = ()) -> Problem:
        """A problem with these as candidates, without some sizes: an effect and a parameter."""
        kept = [i for i, s in enumerate(self.signatures) if (s.effect, s.parameter) not in without]
        columns = _side_by_side([self.columns[i] for i in kept], problem.residual.size)
        return problem.asking(columns=columns, signatures=tuple(self.signatures[i] for i in kept))


def calibration_columns(
    case: Case, rows: Problem, within: FloatArray | None = None
) -> tuple[FloatArray, FloatArray]:
    """``dr/dθ`` of the calibration by central differences, as independent columns.

    Collinear parameters (scale and bias far from zero counts) are turned into independent
    directions; directions that change nothing are dropped.

    Parameters
    ----------
    within
        Changes of the parameters of `Case.calibration` to which it is limited, shape (p, w).

    Returns
    -------
    columns
        Shape (m, rank).
    turn
        Change of each parameter of `Case.calibration` per unit of each column, shape (p, rank).
    """
    parameters = list(case.calibration)
    steps = np.array([parameter.step for parameter in parameters])
    ways = np.diag(steps) if within is None else within
    if not ways.size:
        return np.empty((rows.residual.size, 0)), np.empty((0, 0))
    ways = ways / np.max(np.abs(ways) / steps[:, None], axis=0)
    raw = np.empty((rows.residual.size, ways.shape[1]))
    at = {p.name: case.values.get(p.name, p.value) for p in parameters}
    seen = case.memory()
    reached = np.zeros((ways.shape[1], len(case.logs)), dtype=bool)
    for i, way in enumerate(_DIFFERENCE * ways.T):
        touched = _touched(case, [p.name for p, d in zip(parameters, way, strict=True) if d])
        reached[i, touched] = True
        up, down = (
            residual(case, rows, _moved(case.values, at, sign * way), None, touched, seen)
            for sign in (1.0, -1.0)
        )
        raw[:, i] = (up - down) / (2.0 * _DIFFERENCE)
    norm = np.sqrt(np.sum(raw**2, axis=0))
    norm = np.where(norm > 0, norm, np.inf)
    left, singular, right = _decomposed(raw / norm, reached)
    kept = singular > 1e-9 * singular.max(initial=0.0)
    size = np.sqrt(rows.residual.size)
    turn = ways @ ((right[kept].T / singular[kept]) / norm[:, None]) * size
    return np.asarray(left[:, kept] * size), np.asarray(turn)


def _decomposed(raw: FloatArray, reached: BoolArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Singular value decomposition, of columns that reach other logs each for itself.

    Legs that hang have no log in common: a direction of one leg then holds nothing of the others,
    not even by rounding, and no other log is asked for its derivative.

    Parameters
    ----------
    raw, reached
        Columns, and which logs each may change, shapes (m, n) and (n, logs).
    """
    shared = reached.astype(np.int64) @ reached.T
    count, kin = connected_components(shared)
    if count == 1:
        return np.linalg.svd(raw, full_matrices=False)
    left, singular, right = [], [], []
    for k in range(count):
        mine = np.flatnonzero(kin == k)
        within = np.flatnonzero(np.any(raw[:, mine], axis=1))
        u, s, v = np.linalg.svd(raw[np.ix_(within, mine)], full_matrices=False)
        both = np.zeros((len(raw), s.size)), np.zeros((s.size, raw.shape[1]))
        both[0][within], both[1][:, mine] = u, v
        left.append(both[0])
        singular.append(s)
        right.append(both[1])
    order = np.argsort(-np.concatenate(singular), kind="stable")
    return np.hstack(left)[:, order], np.concatenate(singular)[order], np.vstack(right)[order]


def _touched(case: Case, names: Sequence[str]) -> list[int]:
    """Numbers of the logs whose readings some parameters change."""
    logs: set[int] = set()
    for item in case.chain.links:
        mine = {o for o in item.owners for p in item.effect.parameters if f"{o}.{p.name}" in names}
        members = {member for owner in mine for member in item.owners[owner]}
        logs |= {
            i for i, log in enumerate(case.logs)
            if not members.isdisjoint(units_of(item.effect.scope, log.channels))
        }  # fmt: skip
    return sorted(logs)


def _moved(
    values: Mapping[str, float], at: Mapping[str, float], way: FloatArray
) -> dict[str, float]:
    """Values with the calibration moved some way, shape (p,)."""
    return {
        **values, **{name: v + d for (name, v), d in zip(at.items(), way, strict=True) if d}
    }  # fmt: skip


def direction_columns(case: Case, rows: Problem, *, lasting: bool = False) -> FloatArray:
    """What one prior sd of each way of drifting, or of lasting, adds to the residual, (m, p)."""
    columns, seen = [np.empty((rows.residual.size, 0))], case.memory()
    for direction in case.directions:
        if direction.lasting is not lasting:
            continue
        ends = []
        for sign in (1.0, -1.0):
            moved = dict(case.values)
            for name, change in direction.changes.items():
                moved[name] += 0.01 * sign * change
            ends.append(residual(case, rows, moved, seen=seen))
        columns.append((ends[0] - ends[1])[:, None] / 0.02)
    return np.hstack(columns)


def library_columns(
    case: Case, rows: Problem, effects: Iterable[Effect], measured: Case | None = None
) -> LibraryColumns:
    """Signatures of all effects, for every place that may carry them and every shape.

    Parameters
    ----------
    case
        Recordings as they would be without noise.
    measured
        The recordings themselves, of walks: what is exchanged or reversed as a whole is seen as −1
        from the readings that it made, and noise is nothing beside it.
    """
    fitted = {parameter.name for parameter in case.calibration}
    moved = {item.effect.name for item in case.chain.links if not fitted.isdisjoint(item.names())}
    signatures: list[Signature] = []
    columns: list[FloatArray] = []
    excluded: list[Excluded] = []
    known = set.intersection(*(set(log.known) for log in case.logs))
    responses = Responses(case, rows, case.memory())
    raw = responses if measured is None else Responses(measured, rows, measured.memory())
    for effect in effects:
        given = effect.name in moved or Trait.CALIBRATION in effect.traits
        if given or case.experiment.name not in effect.experiments:
            continue
        if not can_carry(channels_of(case.logs), effect):
            continue
        missing = [name for name in effect.needs if name not in known]
        if missing:
            excluded.append(Excluded(effect.name, "", f"{', '.join(missing)} was not recorded"))
            continue
        if Trait.UNGRADED in effect.traits:
            excluded.append(
                Excluded(effect.name, "", "no graded signature; looked for among the raw data")
            )
            continue
        found, made = effect_columns(raw if effect.name in SWITCHES else responses, effect)
        signatures += found
        columns += made
    return LibraryColumns(tuple(signatures), tuple(columns), tuple(excluded))


def _side_by_side(columns: Sequence[FloatArray], rows: int) -> FloatArray:
    """Columns as one matrix, shape (m, k), in pieces that stay in the processor's cache."""
    out = np.empty((rows, len(columns)))
    for start in range(0, rows if columns else 0, _PIECE):
        piece = slice(start, start + _PIECE)
        out[piece] = np.array([column[piece] for column in columns]).T
    return out


def effect_columns(
    responses: Responses, effect: Effect
) -> tuple[list[Signature], list[FloatArray]]:
    """Columns of one effect; shapes that look alike wherever they are carried are kept once.

    What all cells hear adds to the sum whichever cell it is that they hear: of one cell alone, and
    once the calibration is refitted, the shapes differ.
    """
    case, rows, seen = responses.case, responses.rows, responses.seen
    units, taken = carriers(case, effect), owners_of(case.chain, effect)
    forms = forms_by_unit(case, effect, units)
    signatures: list[Signature] = []
    columns: list[FloatArray] = []
    for size in (s for s in effect.sizes if not s.beside):
        # seen from swapped readings a whole swap is −1; half a swap there is not
        switch = effect.name in SWITCHES
        lower, upper = (-1.3, -0.7) if switch else (size.lower, size.upper)
        if Trait.WHOLE in effect.traits:
            lower, upper = 0.7, 1.3
        kept: list[dict[str, FloatArray]] = []
        for form in filter(None, forms):
            single = responses.of_units(effect, size, form) or {
                u: derivative(case, rows, effect, size, {u: (u,)}, form[u], seen) for u in form
            }
            largest = max(float(np.sqrt(np.mean(c**2))) for c in single.values())
            idle = largest < _CARRIED if switch else largest * size.prior_sd < _NOTHING
            everywhere = {"": np.sum(list(single.values()), axis=0), **single}
            if idle or any(_same_columns(everywhere, other) for other in kept):
                continue
            kept.append(everywhere)
            far = [
                {u: _far(case, rows, effect, size, u, form[u], by, seen) for u in form}
                for by in size.far
            ]
            for where, owners, members in places(effect, units):
                shape = form.get(members[0], {})
                given = not taken.isdisjoint(owner for owner, _ in owners)
                if given or any(form.get(member) != shape for member in members):
                    continue
                bottom, top = lower, upper
                if effect.most is not None:
                    bottom, top = effect.least(size, shape), effect.largest(size, shape)
                signature = Signature(
                    effect=effect.name, parameter=size.name, where=where,
                    unit=unit_of(size.unit, members),
                    shape=tuple(shape.items()), lower=bottom - size.neutral,
                    upper=top - size.neutral, owners=owners,
                )  # fmt: skip
                for of_each in (single, *far):
                    signatures.append(signature)
                    columns.append(summed([of_each[m] for m in members]))
        if not kept and not taken:
            where, owners, _ = places(effect, units)[0]
            signatures.append(Signature(effect.name, size.name, where, size.unit, owners=owners))
            columns.append(np.zeros(rows.residual.size))
    return signatures, columns


def summed(columns: Sequence[FloatArray]) -> FloatArray:
    """Sum of columns; zero where they cancel but for rounding, as legs that stand opposite do."""
    total = np.sum(columns, axis=0)
    largest = max(float(np.linalg.norm(column)) for column in columns)
    return total if np.linalg.norm(total) > _ROUNDING * largest else np.zeros_like(total)


def _same_columns(some: Mapping[str, FloatArray], other: Mapping[str, FloatArray]) -> bool:
    return some.keys() == other.keys() and all(_alike(some[u], other[u]) for u in some)


def _alike(a: FloatArray, b: FloatArray) -> bool:
    norm = np.sqrt((a @ a) * (b @ b))
    return bool(norm > 0 and abs(a @ b) > ALIKE * norm)


def derivative(
    case: Case,
    rows: Problem,
    effect: Effect,
    size: EffectParameter,
    owners: Mapping[str, tuple[str, ...]],
    shape: Mapping[str, float],
    seen: Sequence[Seen] | None = None,
) -> FloatArray:
    """What size one of an effect adds to the residual, shape (m,).

    ``−dr/ds``: removing too little of an effect leaves it in. Central differences where the range
    allows, one-sided at its edge.
    """
    known = seen or case.memory()
    owners = {BESIDE + owner: group for owner, group in owners.items()}
    chain = case.chain.with_link(Link(effect, owners))
    values = dict(case.values)
    for owner in owners:
        values |= {f"{owner}.{name}": value for name, value in shape.items()}

    members = {member for group in owners.values() for member in group}
    touched = [
        i for i, log in enumerate(case.logs)
        if not members.isdisjoint(units_of(effect.scope, log.channels))
    ]  # fmt: skip

    def shifted(by: float) -> FloatArray:
        moved = {f"{owner}.{size.name}": size.neutral + by for owner in owners}
        return residual(case, rows, {**values, **moved}, chain, touched, known)

    low, high = ends_of(size)
    return np.asarray(-(shifted(high) - shifted(low)) / (high - low))


def _far(
    case: Case,
    rows: Problem,
    effect: Effect,
    size: EffectParameter,
    unit: str,
    shape: Mapping[str, float],
    by: float,
    seen: Sequence[Seen],
) -> FloatArray:
    """What an effect of a size far from neutral adds to the residual, over that size, (m,).

    A delay of a quarter of a step has no gradient at none, and one deep minimum where it is.
    """
    owner = BESIDE + unit
    chain = case.chain.with_link(Link(effect, {owner: (unit,)}))
    values = {**case.values, **{f"{owner}.{name}": value for name, value in shape.items()}}
    none, much = (
        residual(
            case, rows, {**values, f"{owner}.{size.name}": size.neutral + change}, chain, seen=seen
        )
        for change in (0.0, by)
    )
    return np.asarray((none - much) / by)


def extended_chain(chain: Chain, effect: Effect, signature: Signature) -> Chain:
    """The chain with a named effect in it."""
    return chain.with_link(Link(effect, dict(signature.owners)))
