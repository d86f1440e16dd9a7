"""Quiet standing: the cells carry the weight, and their centre lies below the CoM.

[NAO], eqs. (12)(13), in the linear form ``Σ (pᵢ − c) fᵢ = 0``; a lifted foot reads zero.
"""

from __future__ import annotations

from dataclasses import replace

from footcal_cli.core.centroidal import Reference
from footcal_cli.core.effects.calibration import SCALE_BIAS
from footcal_cli.core.effects.contract import is_six_axis
from footcal_cli.core.experiments import walk
from footcal_cli.core.experiments.contract import Balance, Experiment
from footcal_cli.core.log import Log


def balance(log: Log) -> Balance:
    """Forces of a log whose distortions are removed against weight and projected CoM."""
    if is_six_axis(log.channels):
        return walk.six_axis_balance(log)
    return walk.cell_balance(log, log.of_known(_reference))


def _reference(log: Log) -> Reference:
    return walk.reference_of(log, static=True)


EXPERIMENT = Experiment(
    name="stand",
    known={key: walk.KNOWN[key] for key in walk.KNOWN},
    balance=balance,
    calibration=(SCALE_BIAS.name,),
    imperfections=(walk.OF_A_MODEL,),
)

ON_SIX_AXIS = replace(
    walk.ON_SIX_AXIS,
    name="stand",
    balance=balance,
    imperfections=(*walk.OF_THE_BODY, *walk.OF_TRANSDUCERS),
)
"""The same on feet with six-axis transducers."""
