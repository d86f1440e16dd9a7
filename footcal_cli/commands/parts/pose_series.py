"""`pose-calib --fit series`: pairs of transducers of which nothing else is known."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from footcal_cli.core.hang.model import AXES
from footcal_cli.core.pose.series import SEEN, UNKNOWN, SeriesFit, fit_series, series_words
from footcal_cli.errors import DataError, UsageError
from footcal_cli.plots.pose import plot_series
from footcal_cli.records.results import RmseRecord, RmseRow, VerdictRecord
from footcal_cli.report import Picture, Report, Sheet, number, with_sd
from footcal_cli.session.session import Outcome
from footcal_cli.tables.columns import six_axis_feet_table

if TYPE_CHECKING:
    from footcal_cli.commands.pose_calib import PoseCalibOptions
    from footcal_cli.session.session import Session


def series_outcome(session: Session[PoseCalibOptions]) -> Outcome:
    """What pairs of transducers on stiff legs say of each other, and what they cannot say."""
    options = session.options
    if not options.series:
        raise UsageError("no pairs named", file=session.recipe.path,
                         remedy="add series = [['hip', 'ankle']] to [pose_calib]")  # fmt: skip
    names = tuple(dict.fromkeys(name for pair in options.series for name in pair))
    with session.step("read"):
        table = session.read_required(six_axis_feet_table(names))[0]
    time_s = table.number("time_s")
    units = ["n"] * 3 + ["nm"] * 3
    wrench = {
        name: table.numbers([f"{name}_{a}_{u}" for a, u in zip(AXES, units, strict=True)])
        for name in names
    }
    sound = np.logical_and.reduce([np.isfinite(w).all(axis=1) for w in wrench.values()])
    step_s = float(np.median(np.diff(time_s)))
    block = max(round(options.block_s / step_s), 1)
    quiet = int(np.sum(time_s[sound] < time_s[0] + options.quiet_s))
    if sound.sum() < 4 * block or quiet < 2 * block:
        raise DataError("too few samples", file=table.path, remedy="record longer")
    with session.step("fit"):
        fits = [
            fit_series(one, two, wrench[one][sound], wrench[two][sound], quiet, block)
            for one, two in options.series
        ]
    seen = SEEN * len(fits)
    return Outcome(
        report=Report(
            title=f"Transducers in series: {session.recipe.robot.name}",
            verdict=VerdictRecord(
                level="warning",
                sentence=f"{seen} of {UNKNOWN * len(fits)} offsets' directions are seen; without "
                "the body's orientation, its mass or an unloaded moment no offset and no weight "
                "can be calibrated from this log.",
                details=(
                    *(word for fit in fits for word in series_words(fit)),
                    "To calibrate: record the body's orientation, hang the robot in two pairs of "
                    "opposite orientations (hang-calib), or lift each foot once (pose-calib --fit "
                    "offsets).",
                ),
            ),
            pictures=(
                Picture(
                    "series", lambda: plot_series(fits),
                    "Force on the second transducer of each pair that the first does not explain, "
                    "over the log: flat while quiet, what appears with tipping is weight turning "
                    "with the leg, hands, or gain.",
                    title="Force that the first transducer of a pair does not explain", zoom=True,
                ),
            ),
            sheets=(_pair_sheet(fits),),
            footer=(
                "Relative rotation by Kabsch's method on changes of force, translation by least "
                f"squares on changes of torque, means over {options.block_s:g} s; combination of "
                f"offsets from the first {options.quiet_s:g} s.",
            ),
        ),
        rmse=RmseRecord(
            rows=tuple(row for fit in fits for row in _rows(fit)),
            rejected={"reading is missing": int((~sound).sum())} if not sound.all() else {},
        ),
    )  # fmt: skip


def _rows(fit: SeriesFit) -> list[RmseRow]:
    stages = (("before", fit.change[:3]), ("after", fit.left[:, :3]))
    return [
        RmseRow(
            quantity=f"{fit.first} to {fit.second} force", unit="N", stage=stage,
            reference="the other transducer", split="all",
            rmse=float(np.sqrt(np.mean(np.square(error)))), n=int(fit.left.shape[0]),
        )
        for stage, error in stages
    ]  # fmt: skip


def _pair_sheet(fits: list[SeriesFit]) -> Sheet:
    return Sheet(
        "Pairs",
        ("first", "second", "turn (°)", "distance (mm)", *(f"o₂−T o₁ {axis}" for axis in AXES),
         "force left (N)"),
        [
            (
                fit.first,
                fit.second,
                number(fit.turn_deg, 3),
                number(1e3 * float(np.linalg.norm(fit.pos_2_m)), 3),
                *(
                    with_sd(float(value), float(sd))
                    for value, sd in zip(fit.combination, fit.combination_sd, strict=True)
                ),
                number(fit.force_left_n, 2),
            )
            for fit in fits
        ],
        note="Offset of the second minus that of the first carried over, in N and Nm, with the "
        "weight of the segment between them in it. ± is the scatter in quiet standing; one degree "
        "of error in the turn moves the forces by 1.7 % of the load as well.",
    )  # fmt: skip
