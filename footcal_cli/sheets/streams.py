"""What was wrong with the streams of standing and walking, as findings."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

from footcal_cli.core.quality import Finding
from footcal_cli.core.signals import Clock, missing_in
from footcal_cli.core.static_init import MISFIT
from footcal_cli.intake.recordings import Recording
from footcal_cli.report import plural

PAUSE_S = 1.0
"""Loggers lose samples for less; a longer gap between stances is where the robot was moved."""


def stream_findings(recording: Recording, *, walking: bool = True) -> Iterator[Finding]:
    """Gaps, repeated and backward stamps of both clocks, a missing angular momentum."""
    merged = recording.merged
    for stream, both in (("cells", merged.sensor_clock), ("body", merged.body_clock)):
        # between stances a recording is stopped: nothing is missing there
        clock = both if walking else without_pauses(both)
        if recording.no_body and stream == "body":
            continue
        where = f"{recording.name} ({stream})"
        if clock.duplicates or clock.backward:
            yield Finding(
                "stamps", "note", where,
                f"{clock.duplicates} repeated and {clock.backward} backward stamps "
                "were dropped",
                "stamp samples where they are taken",
            )  # fmt: skip
        if clock.gaps:
            yield Finding(
                "gaps", "warning", where,
                f"{plural(clock.gaps, 'gap')}, the longest "
                f"{clock.longest_gap_s:.3g} s, about {clock.missing} samples missing",
                "nothing was interpolated across long gaps; look at the logger's load",
            )  # fmt: skip
    if recording.no_angular_momentum and not recording.no_body:
        yield Finding(
            "no_angular_momentum", "note", recording.name,
            f"the log has no rate of angular momentum: it is {_estimated_as(walking)}",
            "log angmom_rate_x_nm and angmom_rate_y_nm, or angmom_x_nms and angmom_y_nms, from the "
            "robot's model",
        )  # fmt: skip


def without_pauses(clock: Clock) -> Clock:
    """The clock without gaps of more than `PAUSE_S`."""
    short = clock.gap_s[clock.gap_s <= PAUSE_S]
    return replace(
        clock, gaps=int(short.size), longest_gap_s=float(short.max(initial=0.0)), gap_s=short,
        missing=missing_in(short, clock.period_s),
    )  # fmt: skip


def _estimated_as(walking: bool) -> str:
    """What stands in for a rate of angular momentum that was not logged."""
    if not walking:
        return "taken as zero, as it is while the robot stands still"
    return (
        "estimated as a share of the body's own motion, and scales are less certain "
        "(the methods window and static take it as zero)"
    )


def standing_findings(recordings: Sequence[Recording], chi2: float, dof: int) -> Iterator[Finding]:
    """What is wrong with the streams, and a residual (chi², rows) beyond noise and prior."""
    for recording in recordings:
        yield from stream_findings(recording, walking=False)
    if recordings[0].no_body:
        yield Finding(
            "no_body", "warning", "log",
            "without a body stream only the total weight is known, not the CoP",
            "log the CoM and the feet's poses besides the cells",
        )  # fmt: skip
    if chi2 > MISFIT * dof:
        yield Finding(
            "misfit", "warning", "stances",
            f"the residual is {(chi2 / dof) ** 0.5:.1f} times what noise and "
            "prior allow",
            "check mass, CoM, cell positions and gains; run diagnose on this log",
        )  # fmt: skip
