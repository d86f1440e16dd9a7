"""How well one leg's hanging logs could be fitted with the signs of some axes turned."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from footcal_cli.core.hang.effect import HangResidual
from footcal_cli.core.hang.joint import HangFit, HangOptions, Hung, white_noise
from footcal_cli.core.hang.levels import fit_reduced
from footcal_cli.core.inference.reduction import Reduced, triangle
from footcal_cli.core.log import Log
from footcal_cli.core.parameters import FloatArray


def misfit_by_signs(
    logs: Sequence[Log], asked: HangOptions, given: HangFit
) -> Callable[[FloatArray], float]:
    """Least ``Σ ‖(s w − ŵ) / sd‖²`` of one leg's wrenches w with any signs s (6,), in one fit.

    Samples count as independent, and what the turning of the leg adds is left in; the sd are those
    of the given fit. Signs turn the reduced records: no sample is read twice.
    """
    hung = Hung.of(logs, asked)
    wrenches = [run.wrench for run in hung.runs]
    sd = np.array([channel.sd for channel in given.noise])
    noise = white_noise(sd)
    triangles = [triangle(*each) for each in zip(hung.designs, wrenches, hung.grams, strict=True)]
    reduced = Reduced.of(hung.designs, wrenches, noise, triangles)
    unseen = sum(float(np.sum((w / sd) ** 2)) for w in wrenches) - float(np.sum(reduced.target**2))

    balance = HangResidual.of(hung.model)

    def misfit(signs: FloatArray) -> float:
        turned = replace(reduced, target=reduced.target * signs[:, None])
        theta = fit_reduced(turned, balance, hung.weight_n).estimates.values
        table = balance.coefficients(theta)
        left = (turned.factor @ table[..., None])[..., 0] - turned.target
        return unseen + float(np.sum(left**2))

    return misfit
