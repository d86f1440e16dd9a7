"""Sizes as they are stated where data determine something else than an effect's parameter."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from footcal_cli.core.chain import Chain, Link
from footcal_cli.core.diagnosis.case import Case
from footcal_cli.core.diagnosis.refit import Refit
from footcal_cli.core.effects.contract import Effect
from footcal_cli.core.evidence import Interval
from footcal_cli.core.log import Log

_STEP = 0.01  # of a parameter, for the derivative


def stated_size(case: Case, model: Refit, effect: Effect, owner: str, parameter: str) -> Interval:
    """The size of an effect of an owner, with its 95 % interval; of several, the one asked for.

    The parameter's own, or what the effect makes of the recorded loads (`Effect.stated`): a loop
    that loads never open in full has a width at those loads, whatever form its model has.
    """
    if effect.stated is None:
        return model.intervals[model.names.index(f"{owner}.{parameter}")]
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
    beyond = float(np.hypot(model.scatter.shared, effect.form_error)) * size
    return model.scatter.interval(size, turn, beyond)


def _largest(
    effect: Effect, link: Link, truths: Sequence[Log], values: Mapping[str, float]
) -> float:
    """The largest of an owner's units over all recordings."""
    assert effect.stated is not None
    (members,) = link.owners.values()
    found = [0.0]
    for truth in truths:
        widths = effect.stated(truth, Chain((link,)).apply(truth, values)[0])
        found += [w for c, w in zip(truth.channels, widths, strict=True) if c in members]
    return float(max(found))
