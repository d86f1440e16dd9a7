"""Mistakes on the bench: a wrong weight, a wrong hole, a wrong unit.

What is believed of a load differs from the truth by a correction: truth = believed + correction.
"""

from __future__ import annotations

import numpy as np

from footcal_cli.core.effects.contract import (
    Effect,
    EffectParameter,
    GridOf,
    Scope,
    Stage,
    State,
    Theta,
    Trait,
    on_known,
    over,
    plus,
    times,
)
from footcal_cli.core.log import Log
from footcal_cli.core.parameters import BoolArray, FloatArray

SAME_LABEL = 3e-3
"""Written loads that differ by less than this share of a label carry it."""
_EVERY_BLOCK = -1.0


def _carries(load: FloatArray, label: float) -> BoolArray:
    found: BoolArray = np.abs(load - label) <= SAME_LABEL * abs(label)
    return found


def _mislabel(load: FloatArray, _log: Log, theta: Theta, state: State) -> tuple[FloatArray, State]:
    """A weight that truly weighs the label, or the label and its error, is written without it."""
    label, wrong = theta["label"][0], theta["label_correction"][0]
    return load - wrong * (_carries(load, label) | _carries(load, label + wrong)), state


def _relabel(load: FloatArray, _log: Log, theta: Theta, state: State) -> tuple[FloatArray, State]:
    label, wrong = theta["label"][0], theta["label_correction"][0]
    return load + wrong * (_carries(load, label) | _carries(load, label - wrong)), state


def _piece(log: Log, theta: Theta) -> FloatArray:
    """The error of one piece wherever it lies; bit k of ``pieces`` says whether piece k does."""
    if "pieces" not in log.known:
        return np.zeros((1, 1))
    lies = log.known["pieces"].astype(np.int64) >> int(theta["piece"][0]) & 1
    there: FloatArray = lies[:, None] * theta["piece_correction"][0]
    return there


def _hole_shift(log: Log, theta: Theta) -> FloatArray:
    shift = np.array([theta["hole_correction_x"][0], theta["hole_correction_y"][0]])
    number = log.known.get("hole", log.block)
    there: FloatArray = (number == int(theta["hole"][0]))[:, None] * shift
    return there


def _unit(log: Log, theta: Theta) -> FloatArray:
    block = theta["unit_block"][0]
    hit = np.full(len(log), True) if block == _EVERY_BLOCK else log.block == int(block)
    factor: FloatArray = np.where(hit, theta["unit_factor"][0], 1.0)
    return factor.reshape(-1, *[1] * (log.known["load_n"].ndim - 1))


WRONG_WEIGHT = Effect(
    name="wrong_weight",
    traits=(Trait.BELIEF, Trait.OF_THE_SUM),
    stage=Stage.BENCH,
    scope=Scope.ROBOT,
    parameters=(
        EffectParameter("label_correction", "N", 0.0, -1e3, 1e3, 0.1),
        EffectParameter(
            "label", "N", 5.0, 1e-3, 1e4, 5.0, True, (0.5, 1.0, 2.0, 5.0, 10.0, 20.0), GridOf.LABEL
        ),
    ),
    apply=on_known("load_n", _mislabel),
    remove=on_known("load_n", _relabel),
    experiments=("weights", "placements"),
    of_recording=True,
    formula="true load = written load + δ wherever the weight with that label was used",
    source="a mislabelled weight; NAO CoP self-calibration uses 0.01, 0.05 and 0.2 kg",
    remedy="put the weight on a balance",
    needs=("load_n",),
    mimics=("nonlinearity", "hinge"),
    separates="use another weight of the same label, or several small ones",
)

WRONG_PIECE = Effect(
    name="wrong_piece",
    traits=(Trait.BELIEF, Trait.OF_THE_SUM),
    stage=Stage.BENCH,
    scope=Scope.ROBOT,
    parameters=(
        EffectParameter("piece_correction", "N", 0.0, -1e3, 1e3, 0.1),
        EffectParameter(
            "piece", "-", 0.0, 0.0, 48.0, 1.0, True, (0.0, 1.0, 2.0, 3.0), GridOf.PIECE
        ),
    ),
    apply=on_known("load_n", plus(_piece, -1.0)),
    remove=on_known("load_n", plus(_piece)),
    experiments=("weights",),
    of_recording=True,
    formula="true load = written load + δ wherever one piece lies in the stack",
    source="a disc that is lighter than its stamp, in stacks of discs",
    remedy="put that piece on a balance",
    needs=("load_n", "pieces"),
    mimics=("wrong_weight", "nonlinearity", "hinge"),
    separates="make the same load of other pieces",
)

WRONG_HOLE = Effect(
    name="wrong_hole",
    traits=(Trait.BELIEF,),
    stage=Stage.BENCH,
    scope=Scope.ROBOT,
    parameters=(
        EffectParameter("hole_correction_x", "m", 0.0, -0.3, 0.3, 0.01),
        EffectParameter("hole_correction_y", "m", 0.0, -0.3, 0.3, 0.01),
        EffectParameter(
            "hole",
            "block",
            0.0,
            0.0,
            1e6,
            1.0,
            True,
            tuple(float(i) for i in range(18)),
            GridOf.HOLE,
        ),
    ),
    apply=on_known("hole_m", plus(_hole_shift, -1.0)),
    remove=on_known("hole_m", plus(_hole_shift)),
    experiments=("placements",),
    of_recording=True,
    formula="true position = written position + δ for one hole",
    source="weight hung into the neighbouring hole of the 20 mm grid",
    remedy="repeat that placement",
    needs=("hole_m",),
    mimics=("cell_position", "slip"),
    separates="repeat the placement and its neighbours",
)

WRONG_UNIT = Effect(
    name="wrong_unit",
    traits=(Trait.BELIEF, Trait.UNGRADED),
    stage=Stage.BENCH,
    scope=Scope.ROBOT,
    parameters=(
        EffectParameter("unit_factor", "-", 1.0, 1e-4, 1e4, 0.3),
        EffectParameter(
            "unit_block", "block", _EVERY_BLOCK, -1.0, 1e6, 1.0, True, (-1.0, 0.0, 1.0, 2.0, 3.0)
        ),
    ),
    apply=on_known("load_n", over(_unit)),
    remove=on_known("load_n", times(_unit)),
    experiments=("weights", "placements"),
    of_recording=True,
    formula="true load = k · written load, in one block or in all: 9.80665 for kg, 4.448 for lbf",
    source="loads noted in another unit than the recipe says",
    remedy="correct the unit in the recipe's columns",
    needs=("load_n",),
    mimics=("scale_bias", "temperature_scale"),
    separates="one weight measured on a balance; the nameplate's scale",
)

EFFECTS = (WRONG_UNIT, WRONG_WEIGHT, WRONG_PIECE, WRONG_HOLE)
