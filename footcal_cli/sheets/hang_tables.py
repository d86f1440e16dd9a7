"""`hang-calib`: tables and error rows."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from footcal_cli.core.effects.calibration import AXES
from footcal_cli.core.hang.joint import HangFit
from footcal_cli.core.hang.runs import HangRun
from footcal_cli.core.parameters import Estimates, FloatArray, Status
from footcal_cli.core.study.stepwise import StepwiseFit
from footcal_cli.records.results import RmseRow
from footcal_cli.report import Sheet, number, with_sd

Residuals = Mapping[str, Mapping[str, FloatArray]]
"""Stage -> leg -> residuals (n, 6)."""
_METHODS = {
    "joint": "Joint: maximum likelihood over all orientations, tilt included",
    "naive": "naive: means of opposite orientations, no tilt",
    "stepwise": "stepwise: Wu & Revzen, III-A, its weight times about the cosine of the tilt",
}


def residuals_by_stage(
    fits: Mapping[str, HangFit],
    others: Mapping[str, Mapping[str, StepwiseFit]],
    runs: Mapping[str, Sequence[HangRun]],
    method: str,
) -> dict[str, dict[str, FloatArray]]:
    """``before``: the naive method where it can be had, else tared readings; then the methods."""
    stages: dict[str, dict[str, FloatArray]] = {
        {"naive": "before"}.get(name, name): {
            leg: np.vstack(fit.residuals(runs[leg])) for leg, fit in own.items()
        }
        for name, own in others.items()
    }
    if not stages:
        stages["before"] = {
            leg: np.vstack([run.wrench for run in own])
            - np.vstack([run.wrench for run in own]).mean(axis=0)
            for leg, own in runs.items()
        }
    joint = {leg: np.vstack(fit.residuals(runs[leg])) for leg, fit in fits.items()}
    if method == "joint":
        return {**stages, "after": joint}
    stages["joint"] = joint
    stages["after"] = stages["before"] if method == "naive" else stages["stepwise"]
    return stages


def rmse_rows(residuals: Residuals, thing: str) -> tuple[RmseRow, ...]:
    """Per stage and leg, forces and torques."""
    return tuple(
        RmseRow.of(f"{leg} {quantity}", unit, stage, f"hanging {thing}", part)
        for stage, legs in residuals.items()
        for leg, left in legs.items()
        for quantity, unit, part in (("force", "N", left[:, :3]), ("torque", "Nm", left[:, 3:]))
    )


def without_intervals(fit: StepwiseFit) -> Estimates:
    """The stepwise or naive result as estimates; the method gives no sd."""
    named = fit.parameters()
    units = tuple(
        "N" if name.endswith((".weight", "_fx", "_fy", "_fz")) else "m" if ".com_" in name else "Nm"
        for name in named
    )
    size = len(named)
    return Estimates(
        tuple(named),
        units,
        np.array(list(named.values())),
        np.full((size, size), np.nan),
        (Status.ESTIMATED,) * size,
    )


def parameter_sheet(chosen: Mapping[str, Estimates], thing: str) -> Sheet:
    """Table II: offsets and weight of the `thing` that hangs, with their sd."""
    rows = []
    for leg, estimates in chosen.items():
        names = ["weight", *(f"offset_{axis}" for axis in AXES)]
        rows.append((leg, *(_shown(estimates, f"{leg}.{name}") for name in names)))
    return Sheet(
        f"Offsets and {thing} weight",
        (sensor_of(thing), "weight (N)", "fx (N)", "fy (N)", "fz (N)", "tx (Nm)", "ty (Nm)",
         "tz (Nm)"),
        rows,
        note="± one standard deviation, autocorrelation of the noise counted; without ± the method "
        "gives none. A dash: not observable from these orientations. Wu & Revzen, Table II.",
    )  # fmt: skip


def sensor_of(thing: str) -> str:
    """What a row or a violin is of: a leg, or a transducer that holds a tool."""
    return "leg" if thing == "leg" else "transducer"


def _shown(estimates: Estimates, name: str) -> str:
    status = estimates.status[estimates.names.index(name)]
    if status is not Status.ESTIMATED:
        return "– not seen"
    return with_sd(estimates[name], estimates.sd_of(name))


def com_sheet(chosen: Mapping[str, Estimates], thing: str) -> Sheet:
    """CoM of the `thing` that hangs, its coefficients in millimetres."""
    rows = []
    for leg, estimates in chosen.items():
        for axis in "xyz":
            cells = []
            for term in ("mean", "sin", "cos"):
                name = f"{leg}.com_{axis}_{term}"
                if name not in estimates.names:
                    cells.append("–")
                elif estimates.status[estimates.names.index(name)] is not Status.ESTIMATED:
                    cells.append("– not seen")
                else:
                    cells.append(with_sd(1e3 * estimates[name], 1e3 * estimates.sd_of(name)))
            rows.append((leg, axis, *cells))
    return Sheet(
        f"{thing.capitalize()} CoM in the transducer frame",
        (sensor_of(thing), "axis", "mean (mm)", "sin φ (mm)", "cos φ (mm)"),
        rows,
        note="First harmonic shown; parameters.json has all.",
    )


def method_sheets(
    fits: Mapping[str, HangFit], others: Mapping[str, Mapping[str, StepwiseFit]], thing: str
) -> tuple[Sheet, ...]:
    """The paper's stepwise method and the naive one beside the joint fit."""
    if not others:
        return ()
    rows = []
    for leg, fit in fits.items():
        for name, value in (
            ("joint", (fit.values.weight_n, fit.values.offset)),
            *((n, (o[leg].weight_n, o[leg].offset)) for n, o in reversed(list(others.items()))),
        ):
            weight, offset = value
            force, torque = (
                (f"{v:z.4f}" for v in (weight, *offset[:3])),
                (f"{v:z.5f}" for v in offset[3:]),
            )
            rows.append((leg, name, *force, *torque))
    return (
        Sheet(
            "Methods side by side",
            (
                sensor_of(thing),
                "method",
                "weight (N)",
                "fx (N)",
                "fy (N)",
                "fz (N)",
                "tx (Nm)",
                "ty (Nm)",
                "tz (Nm)",
            ),
            rows,
            note="; ".join(_METHODS[name] for name in ("joint", *others)) + ".",
        ),
    )


def noise_sheet(fits: Mapping[str, HangFit], thing: str) -> Sheet:
    """Noise per channel, and how many independent samples the log really holds."""
    rows = [
        (
            leg,
            *(number(channel.sd, 2) for channel in fit.noise),
            f"{fit.samples:,}",
            f"{fit.effective_samples.min():,.0f}",
            "; ".join(
                f"{o}: {number(b - min(fit.evidence.values()), 3)}" for o, b in fit.evidence.items()
            ),
        )
        for leg, fit in fits.items()
    ]
    return Sheet(
        "Noise and evidence",
        (sensor_of(thing), "fx (N)", "fy", "fz", "tx (Nm)", "ty", "tz", "samples", "independent",
         "harmonics: BIC above the best"),
        rows,
        note="Slow noise makes neighbouring samples say the same thing; intervals count the "
        "independent ones.",
    )  # fmt: skip
