"""Usual imperfections of an experiment, fitted beside every cause; a large one is a cause again.

A robot's own estimate lacks a share of its angular momentum, is late by a millisecond, and has its
CoM half a millimetre off; a plate moves with the foot below the cells. None of it is worth a name,
and all of it repeats with the gait, so that a test for anything that repeats finds it.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from footcal_cli.core import chances
from footcal_cli.core.effects import TABLE
from footcal_cli.core.effects.contract import Effect, Scope, units_of
from footcal_cli.core.effects.foot import PLATE_INERTIA
from footcal_cli.core.inference.case import Case, channels_of
from footcal_cli.core.inference.grams import whitened_grams
from footcal_cli.core.inference.places import places
from footcal_cli.core.inference.problem import Excluded, Problem, Signature
from footcal_cli.core.inference.scores import coefficients, held_out_gains
from footcal_cli.core.inference.signatures import LibraryColumns, derivative
from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.quality import Finding

LIMIT = 4.0
"""So many usual sizes are the most that an imperfection may have."""
_NOTHING = 1e-6
_LEAST_KG, _APART = 0.1, 0.25
"""Mass below the cells that is worth a remark; share by which those of two feet differ."""
_SURE = 2.0


def with_imperfections(problem: Problem, library: LibraryColumns, ideal: Case) -> Problem:
    """The problem with what every log of its experiment has among what is fitted, and candidates.

    An imperfection that is larger than `LIMIT` usual sizes, or than what matters to a user who said
    so, is none: of the table, it stays a candidate.

    Parameters
    ----------
    problem, library
        The arrays of a model without candidates, and these.
    ideal
        Its recordings without noise.
    """
    columns, signatures = _columns(ideal, problem)
    if not signatures:
        return library.asked_of(problem)
    # rounds, since what one large imperfection pushes another to is no size of that one
    large = _large_elsewhere(problem, library, columns, signatures)
    kept = [k for k, signature in enumerate(signatures) if signature.effect not in large]
    limits = _limits(problem, ideal, columns, signatures)
    beside = replace(problem, usual=columns[:, kept])
    while kept:
        size, sd = sizes_of_imperfections(beside)
        # twice as large is none either, though its evidence be a single block
        beyond = np.maximum(np.abs(size) - 2.0 * sd, 0.5 * np.abs(size)) / limits[kept]
        own = [signatures[k] for k in kept]
        beyond = np.maximum(beyond, _as_vectors(size, sd, limits[kept], own))
        if beyond.max() <= 1.0:
            break
        out = signatures[kept[int(np.argmax(beyond))]].effect
        kept = [k for k in kept if signatures[k].effect != out]
        beside = replace(beside, usual=columns[:, kept])
    covers = {item.effect.name: item.covers for item in ideal.experiment.imperfections}
    names = dict.fromkeys(signatures[k].effect for k in kept)
    fitted = {(signatures[k].effect, signatures[k].parameter) for k in kept}
    fitted |= {(e, p.name) for own in names for e in covers[own] for p in TABLE[e].sizes}
    # every log has a CoM that is off along the floor; one at the wrong height is a cause
    rest = library.asked_of(beside, without=fitted)
    open_still = {s.effect for s in rest.signatures}
    effects = dict.fromkeys(name for own in names for name in (own, *covers[own]))
    reason = f"fitted as a usual imperfection of a {ideal.experiment.name}"
    whole = [e for e in effects if e in TABLE and e not in open_still]
    return rest.asking(
        noise_anew=True,
        usual_of=tuple(signatures[k] for k in kept),
        usual_of_any_size=frozenset(
            item.effect.name for item in ideal.experiment.imperfections if not item.bounded
        ),
        excluded=(*problem.excluded, *(Excluded(e, "", reason) for e in whole)),
    )


def _as_vectors(
    size: FloatArray, sd: FloatArray, limit: FloatArray, signatures: Sequence[Signature]
) -> FloatArray:
    """How far components of one effect and owner are together beyond what is usual, shape (k,).

    An offset along the diagonal is as far as one along an axis: ``√Σ s²`` is compared with what so
    many components rarely exceed, as rarely as one of them exceeds its limit.
    """
    beyond = np.zeros(size.size)
    of = [(s.effect, s.owners) for s in signatures]
    for own in dict.fromkeys(of):
        mine = np.array([one == own for one in of])
        if mine.sum() == 1 or not np.isfinite(limit[mine]).all():
            continue
        rarely = 2.0 * chances.norm_sf(float(limit[mine].min()))
        most = np.sqrt(chances.chi2_isf(rarely, int(mine.sum())))
        norm = float(np.linalg.norm(size[mine]))
        spread = float(np.linalg.norm(size[mine] * sd[mine])) / max(norm, 1e-300)
        beyond[mine] = (norm - 2.0 * spread) / most
    return beyond


def _large_elsewhere(
    problem: Problem,
    library: LibraryColumns,
    columns: FloatArray,
    signatures: Sequence[Signature],
) -> set[str]:
    """Imperfections that predict left-out blocks better at a size far beyond the usual ones.

    A delay of a quarter of a step has no gradient at none: fitted there it looks small, and is not.
    Better at two standard errors of the difference over blocks.
    """
    large, tried = set(), problem
    for name in {s.effect for s in signatures}:
        mine = [i for i, s in enumerate(library.signatures) if s.effect == name]
        usual = [k for k, s in enumerate(signatures) if s.effect == name]
        if len(mine) <= 1 or len(usual) != 1:
            continue
        beside = [k for k in range(len(signatures)) if k not in usual]
        tried = tried.asking(
            columns=np.column_stack([columns[:, usual], *(library.columns[i] for i in mine)]),
            signatures=(signatures[usual[0]], *(library.signatures[i] for i in mine)),
        )
        grams, _ = whitened_grams(tried, columns[:, beside], counted=False)
        base = np.concatenate([grams.calibration, grams.features])
        found = held_out_gains(grams.inner, grams.inner, base, list(grams.candidates[:, None]))
        size = abs(found.size).min(axis=0) / signatures[usual[0]].upper
        more = found.white - found.white[:, :1]
        sure = more.sum(axis=0) > _SURE * np.sqrt(np.sum(more**2, axis=0))
        if np.any((sure & (size > LIMIT))[1:]):
            large.add(name)
    return large


def sizes_of_imperfections(beside: Problem) -> tuple[FloatArray, FloatArray]:
    """Of those of a problem, fitted together beside its calibration, and their sd, (k,) each.

    ``(M + 1) s = g̃ · r``: each is known to one usual size, so that of two that look alike (a delay
    and a lag of some milliseconds) neither grows against the other. The sd is of the jackknife.

    Parameters
    ----------
    beside
        Without candidates; its `Problem.usual` in usual sizes, of which nothing is known yet.
    """
    at = beside.usual_columns
    count = at.stop - at.start
    # in noise beside them: what one far beyond its usual size leaves is none
    grams, _ = whitened_grams(beside, beside.columns, counted=False)
    products = grams.inner.among(np.append(grams.calibration, grams.inner.last))
    # the columns asked for are the last of the calibration, the residual is after them
    base, wanted = np.split(np.arange(products.shape[1]), [-count - 1])
    prior = np.eye(count)

    def fitted(total: FloatArray) -> FloatArray:
        known = coefficients(total, base, wanted)
        left = total[np.ix_(wanted, wanted)] - total[np.ix_(wanted, base)] @ known
        return np.asarray(np.linalg.solve(left[:-1, :-1] + prior, left[:-1, -1]))

    total = products.sum(axis=0)
    without = np.array([fitted(total - own) for own in products])
    share = (len(without) - 1) / max(len(without), 1)
    return fitted(total), np.sqrt(share * np.sum((without - without.mean(axis=0)) ** 2, axis=0))


def moving_masses(problem: Problem) -> dict[str, tuple[float, float]]:
    """Foot -> mass below its cells in kg as its inertia shows, and its sd, where that is sure."""
    if not any(s.effect == PLATE_INERTIA.name for s in problem.usual_of):
        return {}
    size, sd = sizes_of_imperfections(problem.without_candidates)
    return {
        s.where: (float(size[k] * s.upper), float(sd[k] * s.upper))
        for k, s in enumerate(problem.usual_of)
        if s.effect == PLATE_INERTIA.name and size[k] > LIMIT * sd[k]
    }  # fmt: skip


def masses_found(problem: Problem) -> Iterator[Finding]:
    """Masses that move with the feet below their cells, which are fitted beside every cause."""
    found = moving_masses(problem)
    if not found or max(found.values())[0] < _LEAST_KG:
        return
    each = ", ".join(f"{foot} {mass:.2f} ± {sd:.2f} kg" for foot, (mass, sd) in found.items())
    (low, low_sd), (high, high_sd) = min(found.values()), max(found.values())
    apart = len(found) > 1 and high - low > max(_APART * high, LIMIT * np.hypot(low_sd, high_sd))
    yield Finding(
        "mass_below_cells", "warning" if apart else "note", "robot",
        f"below the cells a mass moves with each foot: {each}"
        + ("; the feet differ" if apart else "") + ". Its inertia is fitted with every cause",
        "compare it with what hangs below the cells by weight: soles, plates, halves of cells",
    )  # fmt: skip


def _columns(ideal: Case, rows: Problem) -> tuple[FloatArray, list[Signature]]:
    """What a usual size of each imperfection adds to the residual, shape (m, k)."""
    present = {
        (link.effect.name, member)
        for link in ideal.chain.links for members in link.owners.values() for member in members
    }  # fmt: skip
    known = set.intersection(*(set(log.known) for log in ideal.logs))
    columns, signatures, seen = [np.empty((rows.residual.size, 0))], [], ideal.memory()
    for item in ideal.experiment.imperfections:
        effect = item.effect
        if not known.issuperset(effect.needs):
            continue
        for name, usual in item.usual_on(ideal.logs).items():
            size = next(p for p in effect.sizes if p.name == name)
            for where, owners in _each(ideal, effect):
                if any((effect.name, unit) in present for _, units in owners for unit in units):
                    continue  # one leg's gain is a cause, the other's is as usual
                column = usual * derivative(ideal, rows, effect, size, dict(owners), {}, seen=seen)
                if np.sqrt(np.mean(column**2)) > _NOTHING:
                    columns.append(column[:, None])
                    signatures.append(
                        Signature(effect.name, name, where, size.unit, (), -usual, usual, owners)
                    )
    return np.hstack(columns), signatures


def _each(ideal: Case, effect: Effect) -> list[tuple[str, tuple[tuple[str, tuple[str, ...]], ...]]]:
    """Every single owner of an effect."""
    units = units_of(effect.scope, channels_of(ideal.logs))
    single = [p for p in places(effect, units) if len(p[2]) == 1 or effect.scope is Scope.ROBOT]
    return [(where, owners) for where, owners, _ in single]


def _limits(
    problem: Problem, ideal: Case, columns: FloatArray, signatures: Sequence[Signature]
) -> FloatArray:
    """Largest sizes that are no causes, in usual ones, shape (k,)."""
    free = {i.effect.name for i in ideal.experiment.imperfections if not i.bounded}
    limits = np.array([np.inf if s.effect in free else LIMIT for s in signatures])
    if not ideal.tolerance_stated:
        return limits
    alone = replace(problem.without_candidates, columns=columns, signatures=tuple(signatures))
    smallest = alone.smallest_sizes(alone.left())
    return np.where(np.isfinite(limits), np.minimum(limits, smallest), limits)
