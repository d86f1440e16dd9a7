"""`hang-calib`: report, tables, error rows and sentences."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from footcal_cli.core.effects.six_axis_beliefs import LEG_COM
from footcal_cli.core.hang.binned import binned_com
from footcal_cli.core.hang.dead_axis import dead_axes
from footcal_cli.core.hang.gains import unequal_gains
from footcal_cli.core.hang.joint import HangFit
from footcal_cli.core.hang.runs import HangRun
from footcal_cli.core.hang.words import hanging_thing
from footcal_cli.core.parameters import Estimates, FloatArray
from footcal_cli.core.quality import Finding
from footcal_cli.core.signals import root_mean_square
from footcal_cli.core.study.stepwise import StepwiseFit
from footcal_cli.plots import hang as plots
from footcal_cli.records.results import RmseRecord, VerdictRecord
from footcal_cli.report import Picture, number
from footcal_cli.report.outcome import Outcome
from footcal_cli.sheets.hang_tables import (
    Residuals,
    com_sheet,
    method_sheets,
    noise_sheet,
    parameter_sheet,
    residuals_by_stage,
    rmse_rows,
    sensor_of,
    without_intervals,
)

POOR_FORCE_N = 0.2
"""Wu & Revzen reaches 0.2 N per axis when hanging; a larger sd deserves a warning …"""
POOR_EXCESS = 3.0
"""… where it is more than so many times the scatter from sample to sample."""
_AS_NOISE = 1.5
_SHARED_TILT = "what all legs share is the robot's tilt, where they differ it is the mounting"
_WHAT_REPEATS = "What of it repeats, and why: footcal diagnose --experiment hang."
_LARGE_TILT_DEG = 10.0
_SURE_TILT, _SMALL_TILT_RAD = 4.0, 0.002
_UNEXPLAINED = 0.2
"""Share of the weight that may be left of the forces, where more than noise is left."""
_SYSTEMATIC = 5.0
"""Residual over the scatter from sample to sample from which it is no noise."""
_FARTHEST_M = 3.0
"""No leg and no tool has its CoM farther from its transducer."""


def outcome_of(
    robot: str,
    fits: Mapping[str, HangFit],
    runs: Mapping[str, Sequence[HangRun]],
    others: Mapping[str, Mapping[str, StepwiseFit]],
    method: str,
    rejected: Mapping[str, int],
) -> Outcome:
    """The hanging calibration of a robot.

    Parameters
    ----------
    fits
        Joint fit of every leg.
    runs
        Its log, orientation by orientation.
    others
        Method -> leg -> the same by the paper's methods; empty where none was run.
    method
        The one whose calibration is kept.
    rejected
        Rows by reason.
    """
    residuals = residuals_by_stage(fits, others, runs, method)
    chosen = chosen_estimates(fits, others, method)
    thing = hanging_thing({leg: fit.model.order for leg, fit in fits.items()})
    return Outcome(
        title=f"Hanging calibration of {robot}",
        verdict=verdict(fits, residuals, runs, method),
        pictures=_pictures(fits, runs, residuals, others.get(method), thing),
        sheets=(
            parameter_sheet(chosen, thing),
            com_sheet(chosen, thing),
            *method_sheets(fits, others, thing),
            noise_sheet(fits, thing),
        ),
        findings=tuple(findings(fits, runs)),
        footer=footer(method),
        rmse=RmseRecord(rows=rmse_rows(residuals, thing), rejected=dict(rejected)),
        usable=method != "joint" or all(fit.fit.converged for fit in fits.values()),
    )


def chosen_estimates(
    fits: Mapping[str, HangFit], others: Mapping[str, Mapping[str, StepwiseFit]], method: str
) -> dict[str, Estimates]:
    """Estimates of every leg by the method that was asked for."""
    if method == "joint":
        return {leg: fit.estimates for leg, fit in fits.items()}
    return {leg: without_intervals(other) for leg, other in others[method].items()}


def _com_swing(fits: Mapping[str, HangFit | StepwiseFit]) -> str:
    """How far the CoM of the leg that moves it most travels."""
    phase = np.linspace(0.0, 2 * np.pi, 200)
    travel = {
        leg: 1e3 * float(np.ptp(fit.com_t_m(phase), axis=0).max()) for leg, fit in fits.items()
    }
    leg = max(travel, key=lambda name: travel[name])
    return f"The CoM travels by up to {travel[leg]:.0f} mm per turn of the shaft ({leg})."


def _pictures(
    fits: Mapping[str, HangFit],
    runs: Mapping[str, Sequence[HangRun]],
    residuals: Residuals,
    own: Mapping[str, StepwiseFit] | None,
    thing: str,
) -> tuple[Picture, ...]:
    """Figures of the method that was asked for: `own`, or the joint fit where None."""
    sensor = sensor_of(thing)
    stages = {s: _largest_rms(legs) for s, legs in residuals.items() if s in ("before", "after")}
    pictures = [
        Picture(
            "residuals", lambda: plots.plot_residuals(residuals),
            f"Residual of the readings after offset and {thing} weight are subtracted: one violin "
            f"per {sensor} and axis. A good fit is one narrow hump around zero.",
            title=f"Residual of each {sensor} and axis before and after",
            result="Largest RMS of a force: "
            + ", ".join(f"{number(n, 2)} N {s} ({leg})" for s, (n, leg) in stages.items()) + ".",
        ),
    ]  # fmt: skip
    shown: Mapping[str, HangFit | StepwiseFit] = own or fits
    if any(fit.model.order > 0 for fit in fits.values()):
        binned = {leg: binned_com(fit, runs[leg]) for leg, fit in shown.items()}
        pictures.append(
            Picture(
                LEG_COM.name, lambda: plots.plot_com(shown, binned),
                "Leg CoM in the transducer frame against the shaft angle: dots are medians over "
                "cycles, dark the quartiles, light 95 % of the cycles; dashed the fitted series.",
                title="Leg CoM against shaft angle", result=lambda: _com_swing(shown),
            )
        )  # fmt: skip
    tilted = own is None or any(fit.turn_rad.any() for fit in own.values())
    if tilted and any(fit.model.tilt != "none" for fit in fits.values()):
        directions = {
            leg: fit.gravity_dir_t if own is None else own[leg].gravity_dir_t(runs[leg])
            for leg, fit in fits.items()
        }
        pictures.append(
            Picture(
                "orientations", lambda: plots.plot_tilts(fits, directions),
                "Where gravity really pointed in each orientation, seen along the named axis"
                + (f": {_SHARED_TILT}." if len(fits) > 1 else "."),
                title="Direction of gravity in each orientation",
                result=f"Gravity lies up to {_largest_lean(fits, directions):.1f}° off the named "
                "axis.",
            )
        )  # fmt: skip
    return tuple(pictures)


def _largest_rms(legs: Mapping[str, FloatArray]) -> tuple[float, str]:
    """Largest RMS of a force over legs and axes in N, and its leg."""
    found = {leg: float(np.sqrt((r[:, :3] ** 2).mean(axis=0)).max()) for leg, r in legs.items()}
    leg = max(found, key=lambda one: found[one])
    return found[leg], leg


def _largest_lean(fits: Mapping[str, HangFit], directions: Mapping[str, FloatArray]) -> float:
    """Largest angle between gravity and the named axis, degrees."""
    cosines = [
        float((directions[leg] * fit.model.nominal_dir_t).sum(axis=1).min())
        for leg, fit in fits.items()
    ]
    return float(np.rad2deg(np.arccos(np.clip(min(cosines), -1.0, 1.0))))


def verdict(
    fits: Mapping[str, HangFit],
    residuals: Residuals,
    runs: Mapping[str, Sequence[HangRun]],
    method: str,
) -> VerdictRecord:
    """One sentence with the worst leg's residual, and what is not seen."""
    if method != "joint":
        return _plain_verdict(residuals, method)
    sd = {leg: float(left[:, :3].std(axis=0).max()) for leg, left in residuals["after"].items()}
    worst = max(sd, key=sd.__getitem__)
    gaps = [gap for fit in fits.values() for gap in fit.gaps]
    offset_sd = max(float(fit.estimates.sd[1:4].max()) for fit in fits.values())
    details = [
        f"Force offsets are known to ± {number(offset_sd, 2)} N or better (one sd).",
        *_levels(fits),
        *_bases(fits),
        *gaps[:6],
        *([f"… and {len(gaps) - 6} more."] if len(gaps) > 6 else []),
    ]
    unsound = [leg for leg, fit in fits.items() if not fit.fit.converged]
    if unsound:
        return VerdictRecord(
            level="bad", sentence=f"The fit of {', '.join(unsound)} did not converge.",
            details=tuple(details),
        )  # fmt: skip
    if gaps:
        return VerdictRecord(
            level="warning",
            sentence="These orientations leave part of the calibration unknown: "
            f"{gaps[0].split(': ', 1)[1]}.",
            details=tuple(details),
        )
    excess = fits[worst].misfit(runs[worst])
    poor = sd[worst] > POOR_FORCE_N and excess > POOR_EXCESS
    poor |= any(unequal_gains(parts) for parts in runs.values())
    which = "" if len(fits) == 1 else f" ({worst}, the worst of {len(fits)})"
    return VerdictRecord(
        level="warning" if poor else "good",
        sentence=f"Forces fit to {number(sd[worst], 2)} N sd per axis{which}"
        f"{_beside_noise(excess, poor)}.",
        details=(*details, *([_WHAT_REPEATS] if excess == 0.0 else [])),
    )


def _beside_noise(excess: float, poor: bool) -> str:
    """How a residual compares with the scatter of samples; 0 of it where no attitude has two."""
    missing = ": something is not in the model" if poor else ""
    if excess == 0.0:
        alone = "each attitude has one row, so that nothing says how much of it is noise"
        return f"{missing}; {alone}"
    if not poor and excess <= _AS_NOISE:
        return ", as the noise from sample to sample allows"
    return f", {number(excess, 2)} times the noise from sample to sample{missing}"


def _levels(fits: Mapping[str, HangFit]) -> list[str]:
    """Where levels differ from orientation to orientation by more than noise."""
    sd = {leg: float(fit.level_sd[:3].max()) for leg, fit in fits.items()}
    worst = max(sd, key=sd.__getitem__)
    if not sd[worst] > 0.0:
        return []
    return [
        f"{worst}: levels of the forces differ from hold to hold by {number(sd[worst], 2)} N (sd) "
        "more than noise explains: slow drift, a cable that pulls, or attitudes that are off "
        "(footcal diagnose --experiment hang). The intervals include it."
    ]


def _bases(fits: Mapping[str, HangFit]) -> list[str]:
    """How far from vertical the z axis of the attitude's world is, where that is sure."""
    found = []
    for leg, fit in fits.items():
        names = [f"{leg}.{name}" for name in fit.model.tilt_names() if name.startswith("base")]
        at = [fit.estimates.names.index(name) for name in names]
        lean = fit.estimates.values[at]
        size = float(np.linalg.norm(lean))
        if not size > 0.0:
            continue
        along = lean / size
        sd = float(np.sqrt(along @ fit.estimates.covariance[np.ix_(at, at)] @ along))
        if size > _SURE_TILT * sd and size > _SMALL_TILT_RAD:
            found.append(
                f"{leg}: the base is not level: its z axis is {np.rad2deg(size):.2f}° ± "
                f"{number(np.rad2deg(sd), 1)}° off the vertical, which is taken into account."
            )
    return found


def _plain_verdict(residuals: Residuals, method: str) -> VerdictRecord:
    """The sentence for the stepwise and the naive method, which give no intervals."""
    sd, joint = (
        {leg: float(left[:, :3].std(axis=0).max()) for leg, left in residuals[stage].items()}
        for stage in ("after", "joint")
    )
    worst = max(sd, key=sd.__getitem__)
    return VerdictRecord(
        level="warning" if sd[worst] > POOR_FORCE_N else "good",
        sentence=f"{method}: what hangs is explained to {number(sd[worst], 2)} N sd per axis "
        f"({worst}, the worst of {len(sd)}).",
        details=(
            "This method gives no intervals.",
            f"The joint fit leaves {number(max(joint.values()), 2)} N on the same logs.",
        ),
    )


def findings(
    fits: Mapping[str, HangFit], runs: Mapping[str, Sequence[HangRun]]
) -> Iterator[Finding]:
    """Forces that are no weight, a CoM out of reach, tilts like those of a wrongly named axis."""
    thing = hanging_thing({leg: fit.model.order for leg, fit in fits.items()})
    yield from dead_axes(runs, thing)
    for leg, fit in fits.items():
        yield from _no_weight(leg, fit, runs[leg], f"{thing} {leg}")
        unequal = unequal_gains(runs[leg])
        if unequal:
            yield Finding(
                "unequal_gains", "warning", f"{thing} {leg}",
                f"the gains of the force axes differ by {100 * unequal.spread:.1f} %: a weight and "
                f"a mounting do not explain them, and offsets may be off by "
                f"{number(unequal.offset_moved_n, 2)} N",
                "correct the readings by the transducer's own matrix, or find it by known wrenches",
            )  # fmt: skip
        cosine = np.sum(fit.gravity_dir_t * fit.model.nominal_dir_t, axis=1)
        angle = np.rad2deg(np.arccos(np.clip(cosine, -1.0, 1.0)))
        for label, tilt in zip(fit.model.log_labels(), angle, strict=True):
            if tilt > _LARGE_TILT_DEG:
                yield Finding(
                    "large_tilt", "warning", f"{thing} {leg}, {label.replace('_', ' ')}",
                    f"gravity is {tilt:.0f}° away from the named axis",
                    "check the orientation's name and the transducer's axes "
                    "(orientation_of)",
                )  # fmt: skip


def _no_weight(leg: str, fit: HangFit, runs: Sequence[HangRun], where: str) -> Iterator[Finding]:
    """What shows that the wrenches are not the weight of one thing in the attitudes of the log."""
    weight = float(fit.estimates[f"{leg}.weight"])
    left = np.concatenate(fit.residuals(runs))[:, :3]
    rms = root_mean_square(left)
    if rms > _UNEXPLAINED * abs(weight) and fit.misfit(runs) > _SYSTEMATIC:
        yield Finding(
            "forces_unexplained", "alarm", where,
            f"the forces are not the weight of one thing in the attitudes of the log: "
            f"residual {number(rms, 3)} N per axis at a weight of {number(weight, 3)} N",
            "check the order and the sense of the attitude's angles or quaternion, and "
            "the mounting of the transducer (rotation_rpy_rad)",
        )  # fmt: skip
    com = np.array([float(fit.estimates[f"{leg}.com_{axis}_mean"]) for axis in "xyz"])
    if np.linalg.norm(com) > _FARTHEST_M:
        yield Finding(
            "com_far", "alarm", where,
            f"its CoM would lie {np.linalg.norm(com):.3g} m from the transducer",
            "check the unit of the torques in [columns] (N*mm?)",
        )  # fmt: skip


def footer(method: str) -> tuple[str, ...]:
    """How it was computed."""
    text = {
        "joint": "Joint maximum likelihood over all logs: reading = offset + [m g u; r(φ) × m g u] "
        "with u = exp([s]) e per log, r(φ) a Fourier series with the order of lowest BIC; noise "
        "autoregressive per channel (Wu & Revzen, eqs. (4)–(7), exact in the tilt).",
        "stepwise": "Wu & Revzen, section III-A step by step, Kalman smoother included; no "
        "intervals.",
        "naive": "Half-sums and half-differences of opposite logs without tilt; no intervals.",
    }
    return (text[method],)
