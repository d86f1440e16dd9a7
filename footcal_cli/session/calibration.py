"""The one place where a command makes a ``parameters.json``."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from footcal_cli.core.parameters import Estimates
from footcal_cli.core.quality import Finding
from footcal_cli.errors import DataError, UsageError
from footcal_cli.records.results import (
    LARGEST,
    CovarianceBlock,
    EffectRecord,
    ParameterRecord,
    ParametersRecord,
    Range,
    covariance_blocks,
    parameter_records,
)
from footcal_cli.session.session import Session


@dataclass(frozen=True)
class Conventions:
    """How the values of a calibration are meant: signs, axes and point of expression."""

    signs: str
    frame: str
    expressed_at: str


CELLS = Conventions(
    "force = scale * counts + bias, positive when the cell is pressed",
    "each cell's own axis",
    "the cell",
)
PLACED_CELLS = Conventions(
    CELLS.signs, f"{CELLS.frame}; positions in the foot frame", CELLS.expressed_at
)
STANDING = Conventions(
    "reading = applied wrench + offset", "each transducer's axes", "the transducer"
)
WALKING = Conventions(
    "applied wrench = (1 + scale) * reading - offset", STANDING.frame, STANDING.expressed_at
)
"""Standing leaves scales alone, walking corrects them where the motion tells."""
LEGS = Conventions(
    "reading = applied + offset; applied by leg and ground on the transducer, "
    "[fx fy fz tx ty tz]; leg CoM = mean + sin · sin φ + cos · cos φ",
    "each transducer's own axes",
    "the transducer's origin",
)
MOUNTED_LEGS = Conventions(
    "reading = applied + offset; applied by leg and ground on the transducer; "
    "R_bt = R_nominal exp[mount_rot], hip = nominal + R_nominal mount_pos, both along the nominal "
    "transducer's axes; mount_pos holds minus the shift of the chassis CoM (their sum is seen)",
    "each transducer's own axes; mounting along the nominal ones",
    LEGS.expressed_at,
)


def calibration(
    session: Session[Any],
    conventions: Conventions,
    *groups: Estimates,
    fitted_range: Mapping[str, dict[str, Range]] | None = None,
) -> ParametersRecord:
    """The calibration that the running command has estimated.

    Effects that an earlier calibration contains were undone before the fit; the new one contains
    them still, and where it says nothing else it holds on the same range.
    """
    earlier = session.parameters
    effects = () if earlier is None else earlier.effects
    parameters = dict(earlier.parameters) if earlier is not None and effects else {}
    for group in groups:
        parameters |= parameter_records(group)
    if fitted_range is None and earlier is not None:
        fitted_range = earlier.fitted_range
    return calibration_record(
        session, conventions, parameters, covariance=covariance_blocks(*groups),
        fitted_range=fitted_range, effects=effects,
    )  # fmt: skip


def counted_together(
    session: Session[Any], groups: Sequence[Estimates], apart: Collection[str] = ()
) -> list[Estimates]:
    """Estimates with the calibration of ``--parameters`` as prior, where ``--prior`` asks for it.

    Both are counted together only where chance explains how far they are apart.

    Parameters
    ----------
    session
        Its options have `prior`.
    groups, apart
        As in `footcal_cli.core.inference.earlier.with_earlier`.
    """
    if not session.options.prior:
        return list(groups)
    from footcal_cli.core.inference.earlier import LEAST_P, with_earlier

    earlier = session.parameters
    if earlier is None:
        raise UsageError(
            "prior is asked for, but no calibration is given", file=session.recipe.path,
            remedy="give the earlier calibration with --parameters",
        )  # fmt: skip
    twice = sorted(
        log for log, digest in session.inputs.items() if digest in earlier.inputs.values()
    )
    found = with_earlier(groups, earlier.estimates, apart)
    if twice:
        problem = f"the earlier calibration rests on {twice[0]} too, which would count twice"
        remedy = "give logs that the earlier calibration has not seen, or leave --prior out"
    elif not found.shared:
        problem = "the earlier calibration has an sd for none of the parameters found here"
        remedy = "leave --prior out, or give another calibration"
    elif found.p < LEAST_P:
        problem = (
            "this calibration and the earlier one differ by more than chance explains "
            f"(p = {found.p:.1g})"
        )
        remedy = "find out what has changed since, or leave --prior out"
    else:
        words = (
            f"{len(found.shared)} parameters rest on this run and the calibration it started from"
        )
        session.note([Finding("prior_counted", "note", "prior", words, "nothing to do")])
        return list(found.estimates)
    session.note(
        [Finding("prior_not_counted", "warning", "prior", f"{problem}: it is not counted", remedy)]
    )
    return list(groups)


def feet_calibration(session: Session[Any], estimates: Estimates) -> ParametersRecord:
    """The same for feet on cells or transducers, of `static-init` and `online-replay`."""
    six_axis = not any(foot.cells for foot in session.recipe.robot.feet.values())
    on_transducers = STANDING if session.request.command == "static-init" else WALKING
    return calibration(session, on_transducers if six_axis else CELLS, estimates)


def updated(
    session: Session[Any], conventions: Conventions, estimates: Estimates,
    believed: Mapping[str, ParameterRecord],
) -> ParametersRecord:  # fmt: skip
    """The calibration of ``--parameters`` with what this run found put in; all else is kept."""
    old = session.parameters
    assert old is not None, "checked while reading"
    new = parameter_records(estimates)
    kept = {name: record for name, record in old.parameters.items() if name not in new}
    blocks = list(covariance_blocks(estimates))
    for block in old.covariance:
        left = tuple(name for name in block.names if name in kept)
        if left:
            rows = tuple(tuple(float(x) for x in row) for row in old.covariance_of(left))
            blocks.append(CovarianceBlock(names=left, matrix=rows))
    return calibration_record(
        session, conventions, {**kept, **believed, **new}, covariance=blocks,
        fitted_range=old.fitted_range, effects=old.effects, earlier_inputs=old.inputs,
    )  # fmt: skip


def calibration_record(
    session: Session[Any],
    conventions: Conventions,
    parameters: Mapping[str, ParameterRecord],
    *,
    covariance: Sequence[CovarianceBlock] = (),
    fitted_range: Mapping[str, dict[str, Range]] | None = None,
    effects: Sequence[EffectRecord] = (),
    earlier_inputs: Mapping[str, str] | None = None,
) -> ParametersRecord:
    """The calibration that a run leaves; command, robot, date and inputs are the session's."""
    robot = session.recipe.robot
    for name, own in parameters.items():
        if max(abs(own.value), own.sd or 0.0) > LARGEST:
            raise DataError(
                f"{name} would be {own.value:.2g}: the readings do not depend on the loads",
                remedy="check in [columns] that the column is a reading, and that no rows, files "
                "or channels are mixed up",
            )  # fmt: skip
    return ParametersRecord(
        command=session.request.command,
        created=session.created(),
        robot=robot.name,
        gravity_mps2=robot.gravity_mps2,
        sign_convention=conventions.signs,
        frame=conventions.frame,
        expressed_at=conventions.expressed_at,
        parameters=dict(parameters),
        covariance=tuple(covariance),
        fitted_range=dict(fitted_range or {}),
        effects=tuple(effects),
        inputs={**(earlier_inputs or {}), **session.inputs},
        # what only a rejected calibration was the beginning of is none to start from
        rejected_because=() if session.parameters is None else session.parameters.rejected_because,
    )
