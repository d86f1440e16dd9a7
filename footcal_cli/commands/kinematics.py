"""``footcal kinematics``: joint positions and a URDF to the body stream of a calibration."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer
from pydantic import BeforeValidator, Field

from footcal_cli.commands.options import Logs, NoPictures, Out, Overwrite, Quiet, RecipeFile, begin
from footcal_cli.recipe import CommandOptions, Frozen

if TYPE_CHECKING:
    from footcal_cli.core.kinematics import Accelerations, Posture
    from footcal_cli.core.parameters import FloatArray
    from footcal_cli.core.quality import Finding
    from footcal_cli.intake.rigid_body import RigidBody
    from footcal_cli.session.session import Outcome, Session
    from footcal_cli.tables.table import Table


class JointColumn(Frozen):
    """Where a joint's position stands in the log."""

    column: str
    unit: str | None = None


def _as_column(value: object) -> object:
    return {"column": value} if isinstance(value, str) else value


class KinematicsOptions(CommandOptions):
    """``[kinematics]`` of a recipe.

    `joints` maps joints of the URDF to columns (``"knee"`` or ``{ column = "knee", unit = "deg"
    }``); `fixed` says where joints stand that the log lacks; `feet` names the link of each foot;
    `anchor` is a foot that never moves, for a log without the base's position.
    """

    urdf: str | None = None
    joints: dict[str, Annotated[JointColumn, BeforeValidator(_as_column)]] = Field(
        default_factory=dict
    )
    joint_unit: Literal["rad", "deg"] = "rad"
    fixed: dict[str, float] = Field(default_factory=dict)
    feet: dict[str, str] = Field(default_factory=dict)
    anchor: str | None = None
    cutoff_hz: float = Field(default=10.0, gt=0)


def kinematics(
    logs: Logs = None,
    recipe: RecipeFile = None,
    urdf: Annotated[
        str | None, typer.Option("--urdf", metavar="FILE.urdf", help="The robot's model.")
    ] = None,
    anchor: Annotated[
        str | None,
        typer.Option("--anchor", metavar="FOOT", help="The foot that never moves, if one does."),
    ] = None,
    out: Out = Path("out/kinematics"),
    overwrite: Overwrite = False,
    no_pictures: NoPictures = False,
    quiet: Quiet = False,
) -> None:
    """Turn joint positions and base orientation into CoM, its motion and foot poses."""
    session = begin(
        "kinematics",
        KinematicsOptions,
        logs=logs,
        recipe=recipe,
        out=out,
        overwrite=overwrite,
        quiet=quiet,
        no_pictures=no_pictures,
        urdf=urdf,
        anchor=anchor,
    )
    raise typer.Exit(session.finish(_moved(session)))


def _moved(session: Session[KinematicsOptions]) -> Outcome:
    session.refuse_missing_logs("joints")
    import numpy as np

    from footcal_cli.commands.parts.joint_logs import base_of, feet_frames, joints_of, read_joints
    from footcal_cli.core.kinematics import accelerations, standing_base
    from footcal_cli.core.signals import check_clock
    from footcal_cli.errors import DataError, UsageError
    from footcal_cli.intake.rigid_body import read_urdf

    options = session.options
    if options.urdf is None:
        raise UsageError("no URDF given", remedy="give --urdf FILE.urdf, or urdf in [kinematics]")
    path = Path(options.urdf)
    if not path.is_absolute() and not path.is_file() and session.recipe.path is not None:
        path = session.recipe.path.parent / path
    with session.step("read"):
        body = read_urdf(path)
        feet = feet_frames(session, body)
        log = read_joints(session, body, tuple(feet))
        positions = joints_of(log, body, options)
        base_m, turned = base_of(log)
    stamps = log.number("time_s")
    clock = check_clock(stamps)
    if clock.keep.size < 4:
        raise DataError(
            f"{clock.keep.size} rows with increasing stamps are too few", file=log.path,
            remedy="check the unit of time_s, or record longer",
        )  # fmt: skip
    keep, time_s = clock.keep, stamps[clock.keep]
    known = base_m is not None
    start = np.zeros((keep.size, 3)) if base_m is None else base_m[keep]
    with session.step("kinematics"):
        posture = body.posture(
            time_s, start, turned[keep], {n: p[keep] for n, p in positions.items()},
            list(feet.values()),
        )  # fmt: skip
        if not known:
            fixed = None if options.anchor is None else list(feet).index(options.anchor)
            posture = posture.moved(standing_base(posture.feet_m, fixed))
        found = accelerations(time_s, posture, options.cutoff_hz)
    session.note(_findings(session, body, log, posture, found, tuple(feet), known))
    return _outcome(session, body, time_s, posture, found, tuple(feet), log.path.name)


def _findings(
    session: Session[KinematicsOptions], body: RigidBody, log: Table, posture: Posture,
    found: Accelerations, feet: tuple[str, ...], known: bool,
) -> list[Finding]:  # fmt: skip
    import numpy as np

    from footcal_cli.core.quality import Finding

    robot, where = session.recipe.robot, str(session.options.urdf)
    findings = []
    if robot.mass_kg is not None and abs(body.mass_kg / robot.mass_kg - 1) > _MASS_TOLERANCE:
        findings.append(
            Finding(
                "model_mass_differs", "warning", where,
                f"the URDF weighs {body.mass_kg:.4g} kg, the recipe says {robot.mass_kg:.4g} kg",
                "weigh the robot with battery and cables and correct the one that is wrong: CoM "
                "and L̇ are the URDF's",
            )
        )  # fmt: skip
    columns = [f"{foot}_fz_n" for foot in feet]
    if all(column in log for column in columns):
        carried = float(np.nanmean(log.numbers(columns).sum(axis=1)))
        lifted = float(np.nanmean(found.com_acc_low_mps2[:, 2]))
        weighed = carried / (robot.gravity_mps2 + lifted)
        if abs(weighed / body.mass_kg - 1) > _FORCE_TOLERANCE:
            findings.append(
                Finding(
                    "model_mass_not_carried", "warning", where,
                    f"the feet carry {weighed:.4g} kg on average, the URDF weighs "
                    f"{body.mass_kg:.4g} kg",
                    "check the URDF's masses, the sensors' zero and the sign of fz",
                )
            )  # fmt: skip
    if known:
        seen = posture.feet_m[np.isfinite(posture.feet_m[:, :, 2]).any(axis=1), :, 2]
        ground = float(np.median(np.nanmin(seen, axis=1))) if seen.size else 0.0
        if abs(ground) > _GROUND_TOLERANCE_M:
            findings.append(
                Finding(
                    "feet_not_on_ground", "warning", log.path.name,
                    f"the lower foot is at {1e3 * ground:.3g} mm most of the time, not on the "
                    "ground at z = 0",
                    "give the base's height over the ground, or name the sole's link in "
                    "[kinematics.feet]",
                )
            )  # fmt: skip
    else:
        findings.append(
            Finding(
                "base_position_inferred", "note", log.path.name,
                "the log has no base position; the stance foot is taken to stand still",
                "log the base's position if feet slip or the ground is not level",
            )
        )  # fmt: skip
    return findings


_MASS_TOLERANCE, _FORCE_TOLERANCE, _GROUND_TOLERANCE_M = 0.02, 0.05, 0.02


def _outcome(
    session: Session[KinematicsOptions], body: RigidBody, time_s: FloatArray, posture: Posture,
    found: Accelerations, feet: tuple[str, ...], name: str,
) -> Outcome:  # fmt: skip
    import numpy as np

    from footcal_cli.commands.parts.joint_logs import body_columns, noise_lines
    from footcal_cli.plots.kinematics import plot_accelerations, plot_heights, plot_path
    from footcal_cli.records.results import VerdictRecord
    from footcal_cli.report import Picture, Report, Sheet, number
    from footcal_cli.session.session import Outcome
    from footcal_cli.tables.table import write_parquet

    rate = 1.0 / float(np.median(np.diff(time_s)))
    whole = int(np.isfinite(found.com_acc_mps2).all(axis=1).sum())
    snippet = noise_lines(body.mass_kg, posture, found)
    sheet = Sheet(
        "Noise of the derivatives",
        ("term", "x", "y", "z", "unit"),
        [
            ("acceleration of the CoM", *(number(v, 3) for v in found.com_acc_sd_mps2), "m/s²"),
            ("rate of angular momentum", *(number(v, 3) for v in found.angmom_rate_sd_nm), "N·m"),
        ],
        note=f"Standard deviation behind the {session.options.cutoff_hz:g} Hz low-pass, from what "
        "the joints show above 2.5 times that. noise.toml holds it as force and moment for "
        "[online_replay.noise].",
    )
    names = ", ".join(feet)
    return Outcome(
        report=Report(
            title=f"Kinematics of {session.recipe.robot.name}, {name}",
            verdict=VerdictRecord(
                level="good" if 2 * whole > time_s.size else "warning",
                sentence=f"{whole} of {time_s.size} rows at {rate:.4g} Hz give CoM, acceleration, "
                f"L̇ and the poses of {names}; the model weighs {body.mass_kg:.4g} kg.",
            ),
            pictures=(
                Picture(
                    "accelerations", lambda: plot_accelerations(time_s, found),
                    "The first seconds: central differences (grey), behind the low-pass (blue) "
                    "with ± 2 sd of its noise.",
                    title="Acceleration of the CoM", zoom=True,
                ),
                Picture("path", lambda: plot_path(posture, feet),
                        "The CoM should pass between the feet.",
                    title="Path of the centre of pressure under each foot"),
                Picture(
                    "heights", lambda: plot_heights(time_s, posture, feet),
                    "A standing foot should stay at zero.",
                    title="Height of each foot", zoom=True,
                ),
            ),
            sheets=(sheet,),
            footer=(
                "com_acc and angmom_rate are central differences without a low-pass: the commands "
                "that read body.parquet filter them as they filter the forces. The columns "
                "…_lowpass_… are filtered already.",
            ),
        ),
        files={
            "body.parquet": lambda to: write_parquet(
                body_columns(time_s, posture, found, feet), to
            ),
            "noise.toml": lambda to: _write(to, snippet),
        },
    )  # fmt: skip


def _write(path: Path, text: str) -> None:
    path.write_text(text, encoding="utf-8")
