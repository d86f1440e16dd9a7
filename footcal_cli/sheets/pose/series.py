"""`pose-calib --fit series`: pairs of transducers of which nothing else is known."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from footcal_cli.core.effects.calibration import AXES
from footcal_cli.core.pose.series import SEEN, UNKNOWN, SeriesFit, series_words
from footcal_cli.plots.pose import plot_series
from footcal_cli.records.results import RmseRecord, RmseRow, VerdictRecord
from footcal_cli.report import Picture, Sheet, number, with_sd
from footcal_cli.report.outcome import Outcome


def outcome_of(
    robot: str, fits: Sequence[SeriesFit], lost: int, block_s: float, quiet_s: float
) -> Outcome:
    """What pairs of transducers on stiff legs say of each other, and what they cannot say."""
    seen = SEEN * len(fits)
    return Outcome(
        title=f"Transducers in series: {robot}",
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
                title="Force that the first transducer of a pair does not explain",
                result="RMS, quiet and tipping: "
                + ", ".join(f"{number(f.force_left_n, 2)} N ({f.second})" for f in fits)
                + ".",
                zoom=True,
            ),
        ),
        sheets=(_pair_sheet(fits),),
        footer=(
            "Relative rotation by Kabsch's method on changes of force, translation by least "
            f"squares on changes of torque, means over {block_s:g} s; combination of "
            f"offsets from the first {quiet_s:g} s.",
        ),
        rmse=RmseRecord(
            rows=tuple(row for fit in fits for row in _rows(fit)),
            rejected={"reading is missing": lost} if lost else {},
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


def _pair_sheet(fits: Sequence[SeriesFit]) -> Sheet:
    return Sheet(
        "Pairs",
        ("first", "second", "turn (°)", "distance (mm)", *(f"o₂−T o₁ {axis}" for axis in AXES),
         "residual force (N)"),
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
