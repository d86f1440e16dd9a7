"""A wrong mass in a walk: the gain that all cells share held to what was known before.

A walk whose cells were calibrated on the bench leaves that gain free, for it knows no other force
than the robot's own weight. A wrong mass then shows in no residual, only in a gain far from the
known one; and so does a calibration of which all gains have changed.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from footcal_cli.core.diagnosis.answer import Verdict
from footcal_cli.core.diagnosis.floor import is_large
from footcal_cli.core.diagnosis.inquiry import Inquiry
from footcal_cli.core.diagnosis.investigation import Investigation, named
from footcal_cli.core.diagnosis.standing import happened
from footcal_cli.core.diagnosis.verdicts import may_be_a_curve
from footcal_cli.core.effects.contract import Effect, Trait
from footcal_cli.core.inference.problem import Signature
from footcal_cli.core.inference.tracking import COMMON_GAIN


def with_known_gain(
    found: Investigation, asked: Mapping[str, Effect], inquiry: Inquiry
) -> Investigation:
    """`found`, or what scales all forces; the cells' own calibration is a rival of what does alike.

    Asked only where nothing explains a residual that is large against the known calibration, and
    answered where it is large no more. Single blocks confirm nothing here: each of them has its own
    share of the gain.

    Parameters
    ----------
    asked
        Effects by name that scale all forces, alike (`Trait.ALL_ALIKE`) or nearly.
    """
    held = tuple(way for way in found.case.directions if way.kind != COMMON_GAIN)
    free = len(held) < len(found.case.directions)
    if found.verdict is not Verdict.UNKNOWN or not (free and asked):
        return found
    if not is_large(found.case, found.problem):
        return found
    subject, path = replace(inquiry, table=asked).one_cause(found, held, asked)
    case = subject.case
    if not path.causes or is_large(case, path.current):
        return found
    if may_be_a_curve(subject, path, inquiry.rules, inquiry.seed):
        return found  # of which gains are but the mean
    (cause,) = path.causes
    if not any(Trait.ALL_ALIKE in asked[name].traits for name in cause.effects):
        return found  # what scales them nearly alike was among all the others before
    calibrated = Signature(case.experiment.calibration[0], "scale", "all cells", "")
    cause = replace(cause, rivals=(*cause.rivals, calibrated))
    return named(subject, happened(subject, replace(path, causes=(cause,)), Verdict.AMBIGUOUS))
