"""What each of several effects is worth: added first, added last, and on average over all orders.

Step-wise gains are no attributions: whoever comes first takes what the others could have had too.
The average over all orders is Shapley's value (Lindeman, Merenda and Gold, 1980, for regressions).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from math import comb

import numpy as np

from footcal_cli.core.diagnosis.investigation import Investigation
from footcal_cli.core.inference.grams import whitened_grams
from footcal_cli.core.inference.problem import Signature
from footcal_cli.core.inference.refit import Refit
from footcal_cli.core.inference.scores import held_out_loss
from footcal_cli.core.parameters import FloatArray, IntArray


@dataclass(frozen=True)
class Attribution:
    """The share of the baseline's held-out squared error that an effect takes away.

    Parameters
    ----------
    effect
        Its name.
    first, last
        Added to the bare calibration, and after all the others.
    mean
        On average over all orders.
    """

    effect: str
    first: float
    last: float
    mean: float


def attributions(found: Investigation) -> tuple[Attribution, ...]:
    """Every named effect, on the extended model linearised at its optimum."""
    if found.model is None:
        return ()
    groups = [
        np.array([i for i, name in enumerate(found.model.names) if name in item.parameter_names])
        for item in found.found
    ]
    loss = _losses(found, found.model, groups)
    names = [item.cause.signature.effect for item in found.found]
    return tuple(Attribution(name, *_worth(loss, i, len(names))) for i, name in enumerate(names))


def _losses(
    found: Investigation, model: Refit, groups: Sequence[IntArray]
) -> dict[frozenset[int], float]:
    """Held-out squared error with every subset of the effects in the model."""
    problem = found.problem
    local = replace(
        problem,
        residual=model.residual + model.columns @ _sizes(model),
        columns=model.columns,
        signatures=tuple(Signature("", "", str(i), "") for i in range(len(model.names))),
    )
    grams, _ = whitened_grams(local, np.empty((problem.residual.size, 0)))
    losses = {}
    for count in range(len(groups) + 1):
        for chosen in combinations(range(len(groups)), count):
            parts = [grams.candidates[groups[i]] for i in chosen]
            base = np.concatenate([grams.calibration, *parts])
            losses[frozenset(chosen)] = float(held_out_loss(grams.inner, base, grams.plain).sum())
    return losses


def _sizes(model: Refit) -> FloatArray:
    """Fitted sizes away from neutral, zero for shapes, shape (names,)."""
    parameters = {
        f"{owner}.{p.name}": p
        for item in model.chain.links
        for owner in item.owners
        for p in item.effect.parameters
    }
    return np.array(
        [
            0.0 if parameters[name].shape else model.values[name] - parameters[name].neutral
            for name in model.names
        ]
    )


def _worth(loss: dict[frozenset[int], float], which: int, count: int) -> tuple[float, float, float]:
    """First, last and mean over the orders, as shares of the loss without any effect."""
    others = [i for i in range(count) if i != which]
    baseline = max(loss[frozenset()], 1e-300)

    def bought(before: frozenset[int]) -> float:
        return (loss[before] - loss[before | {which}]) / baseline

    mean = sum(
        bought(frozenset(before)) / (count * comb(count - 1, size))
        for size in range(count)
        for before in combinations(others, size)
    )
    return bought(frozenset()), bought(frozenset(others)), mean
