"""A walk on cells whose gains were known before: a wrong mass, or gains that all have changed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from footcal_cli.core.diagnosis.answer import Verdict
from footcal_cli.core.diagnosis.inquiry import Inquiry
from footcal_cli.core.diagnosis.investigation import Investigation, investigate
from footcal_cli.core.diagnosis.known_gain import with_known_gain
from footcal_cli.core.diagnosis.rules import Rules
from footcal_cli.core.diagnosis.signals import describe
from footcal_cli.core.effects import TABLE
from footcal_cli.core.inference.case import Case
from footcal_cli.core.inference.linear import scaled_inverse
from footcal_cli.core.inference.tracking import gain_and_bias
from tests.core.test_diagnosis_bridge import ROBOT, walk_case

MOVES = 0.01
GAINS = {name: TABLE[name] for name in ("mass", "crosstalk", "load_bypass")}
OTHERS = {name: TABLE[name] for name in ("com_offset", "crosstalk", "delay")}
EXTRA_KG = 0.35


def weighed_before(case: Case) -> Case:
    """The same with a calibration ``F = (1 + γ) F⁰ + β``, γ known to 1 % and β to 0.1 N."""
    covariance = np.zeros((2 * len(ROBOT.channels),) * 2)
    for i, channel in enumerate(ROBOT.channels):
        gain = MOVES * np.array([case.values[f"{channel}.scale"], case.values[f"{channel}.bias"]])
        at = slice(2 * i, 2 * i + 2)
        covariance[at, at] = np.outer(gain, gain) + np.diag([0.0, 0.1**2])
    return replace(
        case, known=scaled_inverse(covariance, 1e-14),
        directions=gain_and_bias(ROBOT.channels, case.values, MOVES),
    )  # fmt: skip


def lighter(case: Case, missing_kg: float) -> Case:
    """The same with a robot that is believed to weigh less than it does."""
    logs = (log.with_known(mass_kg=log.known["mass_kg"] - missing_kg) for log in case.logs)
    return replace(case, logs=tuple(logs))


def diagnosed(case: Case) -> Investigation:
    found = investigate(case, OTHERS, describe, Rules())
    return with_known_gain(found, GAINS, Inquiry(GAINS, describe))


def named(found: Investigation) -> set[str]:
    return {s.effect for f in found.found for s in (f.cause.signature, *f.cause.rivals)}


@pytest.mark.parametrize("seed", [1, pytest.param(2, marks=pytest.mark.slow)])
@pytest.mark.parametrize("extra_kg", [EXTRA_KG, -EXTRA_KG])
def test_a_wrong_mass_is_found_with_its_size_and_the_scales_as_its_rival(
    seed: int, extra_kg: float
) -> None:
    found = diagnosed(lighter(weighed_before(walk_case(seed, None, duration_s=40.0)), extra_kg))
    assert found.verdict is Verdict.AMBIGUOUS
    (item,) = found.found
    # where the cells read too little, part of the load may also pass beside them
    alike = {"mass", "scale_bias"} | ({"load_bypass"} if extra_kg < 0.0 else set())
    assert {"mass", "scale_bias"} <= named(found) <= alike
    (size,) = item.intervals
    assert size.low < extra_kg < size.high
    assert size.high - size.low < abs(extra_kg)


def test_gains_that_all_have_changed_are_the_rival_of_a_mass() -> None:
    case = weighed_before(walk_case(3, None, duration_s=40.0))
    less = {
        name: value * 0.93 if name.endswith((".scale", ".bias")) else value
        for name, value in case.values.items()
    }
    found = diagnosed(weighed_before(replace(case, values=less)))
    assert found.verdict is Verdict.AMBIGUOUS
    assert {"mass", "scale_bias"} <= named(found) <= {"mass", "scale_bias", "load_bypass"}


def test_the_right_mass_and_gains_that_nobody_knew_are_left_alone() -> None:
    case = walk_case(4, None, duration_s=40.0)
    assert diagnosed(weighed_before(case)).verdict is Verdict.NONE
    assert not diagnosed(lighter(case, EXTRA_KG)).found
