"""What was wrong with the streams of standing and walking, as findings."""

from __future__ import annotations

from collections.abc import Sequence

from footcal_cli.intake.recordings import Recording
from footcal_cli.records.results import FindingRecord
from footcal_cli.report import plural

_MISFIT = 3.0
"""chi² per row beyond which the residual is more than noise and prior."""


def stream_findings(recording: Recording) -> list[FindingRecord]:
    """Gaps, repeated and backward stamps of both clocks, a missing angular momentum."""
    found = []
    merged = recording.merged
    for stream, clock in (("cells", merged.sensor_clock), ("body", merged.body_clock)):
        if recording.no_body and stream == "body":
            continue
        where = f"{recording.name} ({stream})"
        if clock.duplicates or clock.backward:
            found.append(
                FindingRecord(
                    code="stamps", severity="note", where=where,
                    sentence=f"{clock.duplicates} repeated and {clock.backward} backward stamps "
                    "were dropped",
                    remedy="stamp samples where they are taken",
                )
            )  # fmt: skip
        if clock.gaps:
            found.append(
                FindingRecord(
                    code="gaps", severity="warning", where=where,
                    sentence=f"{plural(clock.gaps, 'gap')}, the longest "
                    f"{clock.longest_gap_s:.3g} s, about {clock.missing} samples missing",
                    remedy="nothing was interpolated across long gaps; look at the logger's load",
                )
            )  # fmt: skip
    if recording.no_angular_momentum and not recording.no_body:
        found.append(
            FindingRecord(
                code="no_angular_momentum", severity="note", where=recording.name,
                sentence="the log has no angular momentum rate: it is taken as zero, which biases "
                "scales by 10–30 % while walking",
                remedy="log angmom_rate_x_nm and angmom_rate_y_nm from the robot's model",
            )
        )  # fmt: skip
    return found


def standing_findings(
    recordings: Sequence[Recording], chi2: float, dof: int
) -> tuple[FindingRecord, ...]:
    """What is wrong with the streams, and a residual (chi², rows) beyond noise and prior."""
    found = [f for recording in recordings for f in stream_findings(recording)]
    if recordings[0].no_body:
        found.append(
            FindingRecord(
                code="no_body", severity="warning", where="log",
                sentence="without a body stream only the total weight is known, not the CoP",
                remedy="log the CoM and the feet's poses besides the cells",
            )
        )  # fmt: skip
    if chi2 > _MISFIT * dof:
        found.append(
            FindingRecord(
                code="misfit", severity="warning", where="stances",
                sentence=f"the residual is {(chi2 / dof) ** 0.5:.1f} times what noise and "
                "prior allow",
                remedy="check mass, CoM, cell positions and gains; run diagnose on this log",
            )
        )  # fmt: skip
    return tuple(found)
