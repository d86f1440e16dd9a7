"""Tables of a robot with hip transducers, as the arrays the core takes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from footcal_cli.core.chain import Chain, Link, link
from footcal_cli.core.effects import calibration_of, having
from footcal_cli.core.effects.contract import Trait
from footcal_cli.core.log import Log
from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.pose.data import Geometry
from footcal_cli.core.pose.intake import Frames, frames_of
from footcal_cli.core.pose.steady import (
    SteadyRule,
    SteadyStretch,
    StretchVerdict,
    medians,
    steady_stretches,
    why_no_pose,
)
from footcal_cli.core.quality import Finding, some_of
from footcal_cli.core.spatial import rotation_of_rpy
from footcal_cli.errors import DataError, UsageError
from footcal_cli.records.effects import effect_of
from footcal_cli.tables.columns import AXIS_COLUMNS, QUATERNION

if TYPE_CHECKING:
    from footcal_cli.recipe import Recipe
    from footcal_cli.records.results import ParametersRecord
    from footcal_cli.tables.table import Table

_EVEN = 0.5
_MOST_NAMED = 8
_NAMED_SHARE = 0.2
"""A stretch shorter than this share of a pose was never meant as one."""


def geometry_of(recipe: Recipe, chassis_com_b_m: Sequence[float]) -> Geometry:
    """The recipe's nominal mounting, of transducers that the body carries."""
    legs = recipe.robot.legs
    if turning := [name for name, leg in legs.items() if leg.turns_about]:
        raise UsageError(
            f"the transducer of leg '{turning[0]}' turns with its leg (turns_about), and standing "
            "poses need it on the body's side of the shaft", file=recipe.path,
            remedy="calibrate it by hang-calib alone",
        )  # fmt: skip
    return Geometry(
        tuple(legs),
        np.stack([rotation_of_rpy(leg.rotation_rpy_rad) for leg in legs.values()]),
        np.array([recipe.hip_position_m(leg) for leg in legs]),
        np.array(chassis_com_b_m, dtype=float),
    )


def frames_of_tables(tables: Sequence[Table], legs: Sequence[str], key: str) -> Frames:
    """Whole poses or stamps of long tables; equal keys of different files stay apart."""
    names: list[object] = []
    for number, table in enumerate(tables):
        keys = table.number(key) if key == "time_s" else table.text(key)
        names += [(number, value) for value in keys.tolist()]
    index: dict[object, int] = {}
    codes = np.array([index.setdefault(name, len(index)) for name in names])

    def stacked(columns: Sequence[str]) -> FloatArray:
        return np.concatenate([table.numbers(columns) for table in tables])

    columns = {
        "wrench": stacked(AXIS_COLUMNS),
        "phase_rad": stacked(["phase_rad"])[:, 0],
        "body_q": stacked(QUATERNION),
    }
    if key == "time_s":
        columns["time_s"] = stacked(["time_s"])[:, 0]
    if all("contact" in table for table in tables):
        columns["contact"] = stacked(["contact"])[:, 0]
    leg = np.concatenate([table.text("leg") for table in tables])
    missing = [name for name in legs if not np.any(leg == name)]
    if missing:
        raise DataError(
            f"leg '{missing[0]}' of the recipe is not in the log", file=tables[0].path,
            column="leg", remedy="correct the recipe's [robot.legs] or the log",
        )  # fmt: skip
    return frames_of(codes, leg, legs, columns, may_miss=("contact",))


def steady_frames(
    tables: Sequence[Table], legs: Sequence[str], rule: tuple[float, float, float]
) -> tuple[Frames, dict[str, int], list[Finding]]:
    """Poses cut from stand-still streams; discarded stretches by reason, and which they are."""
    kept: list[dict[str, FloatArray]] = []
    rejected: dict[str, int] = {}
    notes: list[Finding] = []
    incomplete = broken = 0
    for table in tables:
        frames = frames_of_tables([table], legs, "time_s")
        incomplete, broken = incomplete + frames.incomplete, broken + frames.broken
        if len(frames.keys) < 3:
            continue
        columns = frames.columns
        time_s = columns["time_s"][:, 0]
        step = np.diff(time_s)
        if step.min() <= 0 or np.ptp(step) > _EVEN * np.median(step) * len(step):
            raise DataError("time stamps do not increase", file=table.path, column="time_s")
        stretches = steady_stretches(time_s, columns["wrench"][..., :3], SteadyRule(*rule))
        for stretch in stretches:
            if stretch.verdict is not StretchVerdict.KEPT:
                name = f"stretch discarded: {stretch.verdict.value}"
                rejected[name] = rejected.get(name, 0) + 1
        notes += _poses_left_out(table.path.name, time_s, stretches, rule[1])
        kept.append({name: medians(values, stretches) for name, values in columns.items()})
    if kept and not any(len(part["wrench"]) for part in kept):
        why, remedy = why_no_pose(time_s, columns["wrench"][..., :3], SteadyRule(*rule))
        raise DataError(f"no pose: {why}", file=table.path, remedy=remedy)
    if not kept:
        return Frames(np.zeros(0), {}, incomplete, broken), rejected, notes
    joined = {name: np.concatenate([part[name] for part in kept]) for name in kept[0]}
    frames = Frames(np.arange(len(joined["phase_rad"])), joined, incomplete, broken)
    return frames, rejected, notes


def _poses_left_out(
    file: str, time_s: FloatArray, stretches: Sequence[SteadyStretch], least_s: float
) -> list[Finding]:
    """Which quiet stretches of a stream did not become a pose; the moving ones are no poses."""
    short = [
        s for s in stretches
        if s.verdict is StretchVerdict.TOO_SHORT and s.duration_s > _NAMED_SHARE * least_s
    ]  # fmt: skip
    if not short:
        return []
    named = [f"{time_s[s.start]:.1f}–{time_s[s.stop - 1]:.1f} s" for s in short]
    return [
        Finding(
            "poses_left_out", "note", file,
            f"quiet for no longer than {least_s:g} s and left out: {some_of(named, _MOST_NAMED)}",
            f"stand still for more than {least_s:g} s in each pose",
        )
    ]  # fmt: skip


_OWN = having(Trait.CALIBRATION, Trait.MOUNTING, Trait.HUNG)
"""Effects that hang-calib and pose-calib estimate themselves."""


def without_effects(log: Log, record: ParametersRecord | None) -> Log:
    """A log with the effects of an extended calibration undone; its offsets stay in.

    Raises
    ------
    UsageError
        Where an effect needs something the log does not have.
    """
    extra = [] if record is None else [e for e in record.effects if e.effect not in _OWN]
    if record is None or not extra:
        return log
    chain = Chain((link(calibration_of(log.channels), log.channels),))
    for item in extra:
        effect = effect_of(item)
        lacking = [name for name in effect.needs if name not in log.known]
        if lacking:
            raise UsageError(
                f"the calibration contains {item.effect}, which needs {', '.join(lacking)}",
                remedy="record it too, or use the calibration without that effect",
            )
        chain = chain.with_link(Link(effect, dict(item.owners)))
    values = record.values
    truth, _ = chain.remove(log, values)
    offset = [values.get(f"{leg}.offset_{axis}", 0.0) for leg, axis in _split(log.channels)]
    return truth.with_readings(truth.readings + np.array(offset))


def _split(channels: Sequence[str]) -> list[tuple[str, str]]:
    """``fl.fx`` to leg and axis."""
    return [(leg, axis) for leg, _, axis in (channel.partition(".") for channel in channels)]
