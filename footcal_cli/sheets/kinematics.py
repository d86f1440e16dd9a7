"""`kinematics`: report, findings, the body stream's columns and its noise."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.quality import Finding
from footcal_cli.intake.joint_motion import JointMotion
from footcal_cli.plots.kinematics import plot_accelerations, plot_heights, plot_path
from footcal_cli.recipe import Robot
from footcal_cli.records.results import VerdictRecord
from footcal_cli.report import Picture, Sheet, number
from footcal_cli.report.outcome import Outcome

_MASS_TOLERANCE, _FORCE_TOLERANCE, _GROUND_TOLERANCE_M = 0.02, 0.05, 0.02


def outcome_of(robot: str, motion: JointMotion, cutoff_hz: float) -> Outcome:
    """Motion of a robot's model along a log."""
    time_s, found, feet = motion.time_s, motion.accelerations, ", ".join(motion.feet)
    rate = 1.0 / float(np.median(np.diff(time_s)))
    whole = int(np.isfinite(found.com_acc_mps2).all(axis=1).sum())
    sheet = Sheet(
        "Noise of the derivatives",
        ("term", "x", "y", "z", "unit"),
        [
            ("acceleration of the CoM", *(number(v, 3) for v in found.com_acc_sd_mps2), "m/s²"),
            ("rate of angular momentum", *(number(v, 3) for v in found.angmom_rate_sd_nm), "N·m"),
        ],
        note=f"Standard deviation behind the {cutoff_hz:g} Hz low-pass, from what "
        "the joints show above 2.5 times that. noise.toml holds it as force and moment for "
        "[online_replay.noise].",
    )
    return Outcome(
        title=f"Kinematics of {robot}, {motion.log}",
        verdict=VerdictRecord(
            level="good" if 2 * whole > time_s.size else "warning",
            sentence=f"{whole} of {time_s.size} rows at {rate:.4g} Hz give CoM, acceleration, "
            f"L̇ and the poses of {feet}; the model weighs {motion.mass_kg:.4g} kg.",
        ),
        pictures=_pictures(motion),
        sheets=(sheet,),
        footer=(
            "com_acc and angmom_rate are central differences without a low-pass: the commands "
            "that read body.parquet filter them as they filter the forces. The columns "
            "…_lowpass_… are filtered already.",
        ),
        tables={"body.parquet": body_columns(motion)},
    )  # fmt: skip


def _pictures(motion: JointMotion) -> tuple[Picture, ...]:
    time_s, posture, feet = motion.time_s, motion.posture, motion.feet
    found = motion.accelerations
    return (
        Picture(
            "accelerations", lambda: plot_accelerations(time_s, found),
            "The first seconds: central differences (grey), behind the low-pass (blue) "
            "with ± 2 sd of its noise.",
            title="Acceleration of the CoM", zoom=True,
            result="Sd of its noise behind the low-pass: "
            + ", ".join(number(v, 2) for v in found.com_acc_sd_mps2)
            + " m/s² in x, y, z.",
        ),
        Picture("path", lambda: plot_path(posture, feet),
                "The CoM should pass between the feet.",
            title="Path of the CoM and the feet, from above",
            result=f"The CoM moves over {_range_m(posture.com_m[:, 0])} m in x and "
            f"{_range_m(posture.com_m[:, 1])} m in y."),
        Picture(
            "heights", lambda: plot_heights(time_s, posture, feet),
            "A standing foot should stay at zero.",
            title="Height of each foot", zoom=True,
            result="Lowest heights: "
            + ", ".join(
                f"{1e3 * float(np.nanmin(posture.feet_m[:, i, 2])):.0f} mm ({foot})"
                for i, foot in enumerate(feet)
            )
            + ".",
        ),
    )  # fmt: skip


def _range_m(values: FloatArray) -> str:
    return number(float(np.nanmax(values) - np.nanmin(values)), 3)


def findings_of(robot: Robot, urdf: str, motion: JointMotion) -> Iterator[Finding]:
    """Masses that contradict each other, feet in the air, a base that is not known.

    Parameters
    ----------
    robot
        Of the recipe.
    urdf
        Name of the file.
    """
    mass_kg, posture = motion.mass_kg, motion.posture
    if robot.mass_kg is not None and abs(mass_kg / robot.mass_kg - 1) > _MASS_TOLERANCE:
        yield Finding(
            "model_mass_differs", "warning", urdf,
            f"the URDF weighs {mass_kg:.4g} kg, the recipe says {robot.mass_kg:.4g} kg",
            "weigh the robot with battery and cables and correct the one that is wrong: CoM "
            "and L̇ are the URDF's",
        )  # fmt: skip
    if motion.carried_n is not None:
        lifted = float(np.nanmean(motion.accelerations.com_acc_low_mps2[:, 2]))
        weighed = motion.carried_n / (robot.gravity_mps2 + lifted)
        if abs(weighed / mass_kg - 1) > _FORCE_TOLERANCE:
            yield Finding(
                "model_mass_not_carried", "warning", urdf,
                f"the feet carry {weighed:.4g} kg on average, the URDF weighs "
                f"{mass_kg:.4g} kg",
                "check the URDF's masses, the sensors' zero and the sign of fz",
            )  # fmt: skip
    if motion.base_known:
        seen = posture.feet_m[np.isfinite(posture.feet_m[:, :, 2]).any(axis=1), :, 2]
        ground = float(np.median(np.nanmin(seen, axis=1))) if seen.size else 0.0
        if abs(ground) > _GROUND_TOLERANCE_M:
            yield Finding(
                "feet_not_on_ground", "warning", motion.log,
                f"the lower foot is at {1e3 * ground:.3g} mm most of the time, not on the "
                "ground at z = 0",
                "give the base's height over the ground, or name the sole's link in "
                "[kinematics.feet]",
            )  # fmt: skip
    else:
        yield Finding(
            "base_position_inferred", "note", motion.log,
            "the log has no base position; the stance foot is taken to stand still",
            "log the base's position if feet slip or the ground is not level",
        )  # fmt: skip


def body_columns(motion: JointMotion) -> dict[str, FloatArray]:
    """Columns of `footcal_cli.tables.columns.body_table`, and the filtered terms."""
    posture, found = motion.posture, motion.accelerations
    columns = {"time_s": motion.time_s}
    for i, axis in enumerate("xyz"):
        columns[f"com_{axis}_m"] = posture.com_m[:, i]
    for i, axis in enumerate("xyz"):
        columns[f"com_acc_{axis}_mps2"] = found.com_acc_mps2[:, i]
        columns[f"com_acc_{axis}_lowpass_mps2"] = found.com_acc_low_mps2[:, i]
        columns[f"angmom_rate_{axis}_nm"] = found.angmom_rate_nm[:, i]
        columns[f"angmom_rate_{axis}_lowpass_nm"] = found.angmom_rate_low_nm[:, i]
    for k, foot in enumerate(motion.feet):
        for i, axis in enumerate("xyz"):
            columns[f"{foot}_foot_{axis}_m"] = posture.feet_m[:, k, i]
        for i, axis in enumerate("xyzw"):
            columns[f"{foot}_foot_q{axis}"] = posture.feet_quaternion[:, k, i]
    return columns


def noise_lines(motion: JointMotion) -> str:
    """The derivatives' noise as force and moment, a table that a recipe takes.

    ``σ_F = m σ(c̈ᶻ)``, ``σ_M² = (m cᶻ σ(c̈))² + σ(L̇)²``, the larger of the two horizontal axes.
    """
    found = motion.accelerations
    acceleration, rate = found.com_acc_sd_mps2, found.angmom_rate_sd_nm
    if not np.isfinite([*acceleration, *rate]).all():
        return "# the rate is too low for the noise of the derivatives\n"
    arm = motion.mass_kg * float(np.nanmedian(motion.posture.com_m[:, 2]))
    moment = max(float(np.hypot(arm * acceleration[0], rate[1])),
                 float(np.hypot(arm * acceleration[1], rate[0])))  # fmt: skip
    return (
        "# noise of the derivatives alone; left out, online-replay learns these from the walk,\n"
        "# errors of the model included\n"
        "[online_replay.noise]\n"
        f"force_n = {motion.mass_kg * acceleration[2]:.4g}\n"
        f"moment_nm = {moment:.4g}\n"
    )
