"""Sizes as they are stated where data determine something else than an effect's parameter."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from footcal_cli.core.chain import Chain, Link
from footcal_cli.core.diagnosis.subject import Subject
from footcal_cli.core.effects.contract import OF_THE_LOGS, Effect, EffectParameter, GridOf
from footcal_cli.core.inference.case import Case
from footcal_cli.core.inference.evidence import Interval
from footcal_cli.core.inference.grams import whitened_grams
from footcal_cli.core.inference.ideal import balanced
from footcal_cli.core.inference.problem import Signature
from footcal_cli.core.inference.refit import Refit
from footcal_cli.core.inference.scores import scores
from footcal_cli.core.inference.shapes import shapes_of
from footcal_cli.core.inference.signatures import derivative
from footcal_cli.core.log import Log

_STEP = 0.01  # of a parameter, for the derivative
_FINER = 4  # steps between two values of a grid
_LEFT_OPEN = 3.84  # twice the log-likelihood ratio that one degree of freedom exceeds in 5 %


def stated_size(
    subject: Subject, model: Refit, effect: Effect, owner: str, parameter: str
) -> Interval:
    """The size of an effect of an owner, with its 95 % interval; of several, the one asked for.

    The parameter's own, in every form that the data leave open, or what the effect makes of the
    recorded loads (`Effect.stated`): a loop that loads never open in full has a width at those
    loads, whatever form its model has.
    """
    if effect.stated is None:
        own = model.intervals[model.names.index(f"{owner}.{parameter}")]
        return in_any_form(own, _other_forms(subject, model, effect, owner, parameter))
    case = subject.case
    mine = [item for item in model.chain.links if item.effect is effect and owner in item.owners]
    link = Link(effect, {owner: mine[0].owners[owner]})
    truths = [model.chain.remove(log, model.values)[0] for log in case.logs]

    def value(values: Mapping[str, float]) -> float:
        return _largest(effect, link, truths, values)

    turn = np.zeros(len(model.names))
    for i, name in enumerate(model.names):
        if name.rsplit(".", 1)[0] == owner and name.rsplit(".", 1)[1] in effect.parameter_names:
            step = _STEP * (abs(model.values[name]) or effect.size.prior_sd)
            up, down = (
                value({**model.values, name: model.values[name] + s}) for s in (step, -step)
            )
            turn[i] = (up - down) / (2.0 * step)
    size = value(model.values)
    beyond = float(np.hypot(model.scatter.shared, effect.form_error)) * abs(size)
    return model.scatter.interval(size, turn, beyond)


def in_any_form(own: Interval, others: Sequence[float]) -> Interval:
    """An interval that holds the sizes of other forms too, each as sure as its own share."""
    shares = [1.0, *(size / own.value for size in others if own.value)]
    ends = [share * end for share in shares for end in (own.low, own.high)]
    return Interval(own.value, min(ends), max(ends))


def _other_forms(
    subject: Subject, model: Refit, effect: Effect, owner: str, parameter: str
) -> list[float]:
    """Sizes of an effect in those other forms that explain the data as well as any.

    A form is what no refit moves along: which of its neighbours a cell hears, the load between two
    weights at which a bypass begins, a time constant far beyond the pauses. Where a plate shares a
    load in a plane, the mean of three neighbours is two thirds of one of them and a gain, which
    calibration absorbs. The moment of a series is known to a row. Forms within the 95 % limit of
    the likelihood ratio are left open.
    """
    held = [
        p for p in effect.shapes
        if f"{owner}.{p.name}" not in model.names and p.grid_of not in OF_THE_LOGS
    ]  # fmt: skip
    if held and subject.problem.rate_hz > 0:
        held = [p for p in held if p.grid_of is not GridOf.SPAN]
    if not held:
        return []
    link = next(k for k in model.chain.links if k.effect is effect and owner in k.owners)
    mine = {p.name: model.values[f"{owner}.{p.name}"] for p in effect.shapes}
    size = next(p for p in effect.sizes if p.name == parameter)
    bare = subject.case.extended(*_without(model, link))
    ideal = balanced(bare, bare.values, bare.chain).extended(bare.chain, bare.values)
    forms, seen = _forms(ideal, effect, link.owners[owner], held, mine), ideal.memory()
    owners = {owner: link.owners[owner]}
    columns = np.stack(
        [
            derivative(ideal, subject.problem, effect, size, owners, form, seen=seen)
            for form in (mine, *forms)
        ],
        axis=1,
    )
    at = model.names.index(f"{owner}.{parameter}")
    beside = np.delete(model.columns, at, axis=1)
    whole = model.residual + model.intervals[at].value * columns[:, 0]
    scale = np.sqrt(np.mean(columns**2, axis=0)) + 1e-300
    signatures = (Signature(effect.name, parameter, owner, ""),) * columns.shape[1]
    local = replace(
        subject.problem, residual=model.residual, accepted=beside if beside.size else None,
        columns=columns / scale, signatures=signatures,
    )  # fmt: skip
    noise = local.law
    grams, _ = whitened_grams(replace(local, residual=whole), np.empty((whole.size, 0)), noise)
    scored = scores(grams.inner, grams.calibration, grams.candidates)
    bought = scored.score.sum(axis=0) * scored.size
    same = (bought.max() - bought < _LEFT_OPEN) & (scored.inside == 0)
    # relative to the fitted form in this linear picture, so that only the ratio is its
    ratio = (scored.size / scale) / (scored.size[0] / scale[0])
    sizes = model.intervals[at].value * ratio
    allowed = (sizes >= size.lower) & (sizes <= size.upper)
    return [float(s) for s in sizes[1:][(same & allowed)[1:]]]


def _forms(
    case: Case,
    effect: Effect,
    units: Sequence[str],
    held: Sequence[EffectParameter],
    mine: Mapping[str, float],
) -> list[dict[str, float]]:
    """Forms that differ in those shapes that the refit held, the others as it found them."""
    grid = shapes_of(case, effect, units)
    if len(held) == 1 and grid and held[0].unit != "channel":
        # one alone can be followed closely: which values fit hardly depends on the others
        grid = [{held[0].name: value} for value in _between(held[0], grid)]
    tried = [{**mine, **{p.name: form[p.name] for p in held}} for form in grid]
    return [form for i, form in enumerate(tried) if form != mine and form not in tried[:i]]


def _between(shape: EffectParameter, grid: Sequence[Mapping[str, float]]) -> list[float]:
    """Values of a shape on its grid and between; of a load, up to the largest there is."""
    values = sorted({form[shape.name] for form in grid})
    if shape.grid_of is GridOf.LOAD:
        values.append(max(values[-1] / max(shape.grid), values[-1]))
    places = np.arange(0, len(values) - 1 + 1e-9, 1.0 / _FINER)
    return [float(v) for v in np.interp(places, np.arange(len(values)), values)]


def _without(model: Refit, link: Link) -> tuple[Chain, dict[str, float]]:
    """Chain and values of a model without one of its links."""
    names = {f"{owner}.{p}" for owner in link.owners for p in link.effect.parameter_names}
    kept = Chain(tuple(k for k in model.chain.links if k is not link))
    return kept, {k: v for k, v in model.values.items() if k not in names}


def _largest(
    effect: Effect, link: Link, truths: Sequence[Log], values: Mapping[str, float]
) -> float:
    """The largest of an owner's units over all recordings, with its sign."""
    assert effect.stated is not None
    (members,) = link.owners.values()
    found = [0.0]
    for truth in truths:
        widths = effect.stated(truth, Chain((link,)).apply(truth, values)[0])
        found += [w for c, w in zip(truth.channels, widths, strict=True) if c in members]
    return float(max(found, key=abs))
