"""What a recipe states against what a log says: scales, weights, and channels that cannot be right.

Every function returns findings that name the likely cause; none of them changes a number.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.quality import UNIT_RATIOS, Finding, listed

SCALE_RANGE = (0.5, 2.0)
"""A cell whose scale is off its nameplate by more is another cell, or its loads another unit."""
LIGHT_LEGS = 0.12
"""Legs that are a smaller share of their robot may be weighed in kgf or lbf; few are so light."""
TOTAL_RANGE = (0.5, 1.5)
"""Walking and standing, the vertical forces sum to the weight on average; calibrations are off by
per cents, wrong units and calibrations of other robots by factors."""
UNIT_TOLERANCE = 0.1
"""Share by which a nameplate may be off beside a unit."""
DEAD_SHARE = 0.01
"""A cell under a walking robot that moves less than this share of its siblings carries nothing."""
_MISSING, _MOSTLY = 0.02, 0.5
TURNED_SHARES = 0.3
"""Known loads turn a cell's share over by all of it; crosstalk and misplaced cells do not."""
OPEN_SD = 1.645
"""One-sided 5 % of a normal: within so many standard deviations of 0 a scale has no known sign."""
WALKING_SPAN_N = 2.0
"""Siblings that move less do not tell a dead cell from one that is not loaded."""
TURNED_SHARE = 0.1
"""A cell of the right sign is not unloaded by this share of its siblings when its foot lands."""


def check_scale(channel: str, scale: float, nameplate: float | None) -> list[Finding]:
    """Find a fitted scale that the nameplate contradicts: another unit of the loads, a turned sign.

    Parameters
    ----------
    scale, nameplate
        N/count.
    """
    if not nameplate or not np.isfinite(scale):
        return []
    ratio = scale / nameplate
    if SCALE_RANGE[0] < ratio < SCALE_RANGE[1]:
        return []
    unit = _unit_of_loads(ratio)
    if unit is not None:
        cause = f"the loads look noted in {unit}" + (" with a reversed sign" if ratio < 0 else "")
    elif ratio < 0 and SCALE_RANGE[0] < -ratio < SCALE_RANGE[1]:
        cause = "the sign of the loads looks reversed, or two wires of the bridge exchanged"
    else:
        cause = "the unit of the loads, the amplifier's gain or the nameplate is wrong"
    return [
        Finding(
            "scale_off_nameplate", "alarm", channel,
            f"the scale is {scale:.3g} N/count, {ratio:.3g} times the {nameplate:.3g} N/count of "
            f"the nameplate: {cause}",
            "correct the unit of the load column in [columns], or scale_n_per_count in "
            "[robot.nameplate]",
        )
    ]  # fmt: skip


def check_determined(channel: str, scale: float, sd: float) -> list[Finding]:
    """Find a scale that its own readings leave open: its sign is not known at 95 %.

    Parameters
    ----------
    scale, sd
        N/count; an sd of NaN says nothing.
    """
    if not abs(scale) < OPEN_SD * sd:
        return []
    return [
        Finding(
            "scale_undetermined", "alarm", channel,
            f"the readings do not determine the scale: {scale:.3g} ± {sd:.2g} N/count, not even "
            "its sign",
            "look at the readings next to the loads: a value that stands for none (9999), rows "
            "that are mixed up, or a cell that does not carry the weight",
        )
    ]  # fmt: skip


def check_gains(channels: Sequence[str], gain: FloatArray) -> list[Finding]:
    """Find scales that a fit without known loads moved out of reason: another solution, or none.

    Whatever sd is stated: where rows contradict each other it grows with the error.

    Parameters
    ----------
    gain
        Relative change γ of each scale against the one before, shape (c,); NaN counts as found.
    """
    return [
        Finding(
            "scale_out_of_reason", "alarm", channel,
            f"the scale came out {1.0 + change:.3g} times what it was before: no cell changes so "
            "much and works: the fit went astray, or the scale before was another cell's",
            "do not use it; compare the body's stream and the feet's places with the recipe "
            "(footcal check), or calibrate with weights (footcal offline-fit)",
        )
        for channel, change in zip(channels, gain, strict=True)
        if not SCALE_RANGE[0] < 1.0 + change < SCALE_RANGE[1]
    ]  # fmt: skip


def _unit_of_loads(ratio: float) -> str | None:
    """The unit in which loads were noted that read so many times what they should in newtons."""
    # loads noted in kg and read as N make a scale 9.8 times too small
    units = {unit: 1.0 / newtons for unit, newtons in UNIT_RATIOS.items()}
    return next((u for u, r in units.items() if abs(abs(ratio) / r - 1.0) < UNIT_TOLERANCE), None)


_SAME_LOAD = 1e-9
"""Means of one weight differ by rounding."""


def check_shares(
    forces_n: FloatArray, cells: Sequence[str], load_n: FloatArray, *, calibrated: bool
) -> list[Finding]:
    """Find cells of a foot that known loads on it contradict: ``Σ s_i F_i + f = W``, s_i near 1.

    Parameters
    ----------
    forces_n
        By the calibration or, up to a common factor, by the nameplate, shape (n, c).
    load_n
        Weights W put on the foot, shape (n,).
    calibrated
        Whether the forces are in newtons.
    """
    good = np.isfinite(forces_n).all(axis=1) & np.isfinite(load_n)
    force, load = forces_n[good], load_n[good]
    count = len(cells)
    # a plate that gives its CoP alone has no cells
    if (
        not count
        or len(load) < 3 * count
        or not (np.ptp(force, axis=0) > 0).all()
        or not np.ptp(load) > _SAME_LOAD * np.abs(load).max()
    ):
        return []
    centre, size = force.mean(axis=0), force.std(axis=0)
    design = np.column_stack([(force - centre) / size, np.ones(len(load))])
    left, singular, right = np.linalg.svd(design, full_matrices=False)
    if singular[-1] < 1e-6 * singular[0]:
        return []
    found = right.T @ (left.T @ load / singular)
    noise = np.sqrt(np.sum((load - design @ found) ** 2) / (len(load) - count - 1))
    sd = noise * np.sqrt(np.sum((right.T / singular) ** 2, axis=1))[:count] / size
    holds = np.unique(load.round(3)).size + np.count_nonzero(np.diff(load))
    sd *= max(1.0, np.sqrt(len(load) / holds))  # rows of one hold share its error
    share = found[:count] / size
    typical = float(np.median(share))
    if not calibrated:
        share, sd, typical = share / typical, sd / abs(typical), 1.0
    turned = (share * np.sign(typical) < -TURNED_SHARES * abs(typical)) & (np.abs(share) > 4.0 * sd)
    if 0 < turned.sum() < count / 2:
        return [
            Finding(
                "turned_sign", "alarm", cell,
                f"the cell reads less where it carries more: of each newton it shows, {s:.2g} N "
                f"are of the weights on the foot, of the other cells' {typical:.2g} N",
                "check the sign of its scale and the wires of its bridge",
            )
            for cell, s in zip(np.array(cells)[turned].tolist(), share[turned], strict=True)
        ]  # fmt: skip
    if SCALE_RANGE[0] < typical < SCALE_RANGE[1]:
        return _missing_share(force, load, cells) if calibrated else []
    unit = _unit_of_loads(typical)
    cause = (
        f"the loads look noted in {unit}" if unit is not None
        else "the unit of the loads or the calibration is wrong"
    ) + (", with a reversed sign" if typical < 0 else "")  # fmt: skip
    return [
        Finding(
            "loads_off_calibration", "alarm", ", ".join(cells),
            f"the weights on the foot are {typical:.3g} times what its calibrated cells show: "
            f"{cause}",
            "correct the unit of the load column in [columns], or give the calibration of this "
            "foot",
        )
    ]  # fmt: skip


def _missing_share(force_n: FloatArray, load_n: FloatArray, cells: Sequence[str]) -> list[Finding]:
    """All cells together show less of the weights than they did one by one.

    ``Σ F_i = a W + b``: a below 1 by 2 % and 5 sd, where it takes most of what the total misses.
    More than all of it is crosstalk, which the correction of the CoP holds.
    """
    total = force_n.sum(axis=1)
    lever = load_n - load_n.mean()
    share = float(lever @ total / (lever @ lever))
    left = total - total.mean() - share * lever
    sd = float(np.sqrt(left @ left / max(load_n.size - 2, 1) / (lever @ lever)))
    missed = total - load_n
    less = 1.0 - share > max(_MISSING, 5.0 * sd)
    if not less or left @ left > _MOSTLY * float(missed @ missed):
        return []
    return [
        Finding(
            "weights_not_all_shown", "warning", ", ".join(cells),
            f"together they show {100 * share:.1f} ± {100 * sd:.1g} % of the weights on the foot, "
            "by the calibration that each was given",
            "look for a second load path parallel to the cells, and whether they were weighed in "
            "the same mounting",
        )
    ]  # fmt: skip


def check_total_force(total_n: FloatArray, weight_n: float | None, where: str) -> list[Finding]:
    """Find vertical forces of a standing or walking robot that do not carry its weight.

    Parameters
    ----------
    total_n
        Sum of all vertical forces, shape (n,); NaN where a sample was lost.
    weight_n
        m g of the recipe.
    """
    good = total_n[np.isfinite(total_n)]
    if not weight_n or not good.size:
        return []
    mean = float(np.median(good))
    if TOTAL_RANGE[0] < mean / weight_n < TOTAL_RANGE[1]:
        return []
    return [
        Finding(
            "total_force_off_weight", "alarm", where,
            f"the vertical forces sum to {mean:.4g} N (median), the robot weighs {weight_n:.4g} N",
            "check that the calibration is of this robot, its sign and unit, and mass_kg in "
            "[robot]; a robot that hangs or is held shows this too",
        )
    ]  # fmt: skip


def check_supported(error_n: FloatArray, weight_n: float, where: str) -> list[Finding]:
    """Find forces that do not carry what they support, by most of its weight, before any fit.

    Parameters
    ----------
    error_n
        Sum of all forces minus what the weight demands, shape (n, 3).
    weight_n
        Of what is supported.
    """
    good = error_n[np.isfinite(error_n).all(axis=1)]
    off = float(np.median(np.linalg.norm(good, axis=1))) if len(good) else 0.0
    if not weight_n > 0 or off < (1.0 - TOTAL_RANGE[0]) * weight_n:
        return []
    return [
        Finding(
            "forces_off_weight", "alarm", where,
            f"the forces miss the {weight_n:.4g} N that they carry by {off:.4g} N (median)",
            "check the unit of the forces in [columns], mass_kg in [robot] and that the "
            "calibration is of this robot",
        )
    ]  # fmt: skip


@listed
def check_leg_weights(
    weights_n: Mapping[str, float], robot_n: float | None,
    stated_n: Mapping[str, float] | None = None,
) -> Iterator[Finding]:  # fmt: skip
    """Find leg weights that cannot be: negative, together more than the robot, not as stated.

    Parameters
    ----------
    weights_n
        Weight that each transducer carried while hanging.
    robot_n
        m g of the recipe, None where it is not given.
    stated_n
        Weights of legs that the recipe gives.
    """
    stated = [
        finding
        for leg, weight in weights_n.items()
        if weight > 0 and stated_n is not None and leg in stated_n
        for finding in _off_statement(leg, weight, stated_n[leg])
    ]
    if stated:
        yield from stated
        return
    findings = [
        Finding(
            "negative_leg_weight", "alarm", leg,
            f"the leg weighs {weight:.3g} N: its wrench is turned, or orientations are exchanged",
            "check the transducer's axes and the names of the orientations in the log",
        )
        for leg, weight in weights_n.items()
        if weight < 0
    ]  # fmt: skip
    yield from findings
    total = sum(weights_n.values())
    if robot_n is not None and not findings and total > robot_n:
        yield Finding(
            "legs_heavier_than_robot", "alarm", "all legs",
            f"the legs weigh {total:.4g} N together, the robot {robot_n:.4g} N",
            "check the unit of the forces (N or kgf?) in [columns], and mass_kg in [robot]",
        )  # fmt: skip
    known = stated_n is not None and weights_n.keys() <= stated_n.keys()
    light = robot_n is not None and total < LIGHT_LEGS * robot_n
    if robot_n is not None and light and not findings and len(weights_n) > 1 and not known:
        yield Finding(
            "legs_very_light", "warning", "all legs",
            f"the legs weigh {total:.4g} N together, {total / robot_n:.1%} of the robot; it "
            f"would be {total * UNIT_RATIOS['lbf'] / robot_n:.0%} had the forces been noted in "
            f"lbf, {total * UNIT_RATIOS['kg'] / robot_n:.0%} in kgf",
            "check the unit of the forces in [columns]; where so little hangs below the "
            "transducers, give each leg's mass_kg in [robot.legs]",
        )  # fmt: skip


def _off_statement(leg: str, weight_n: float, stated_n: float) -> list[Finding]:
    ratio = weight_n / stated_n
    if SCALE_RANGE[0] < ratio < SCALE_RANGE[1]:
        return []
    unit = _unit_of_loads(ratio)
    return [
        Finding(
            "leg_weight_off_recipe", "alarm", leg,
            f"the leg weighs {weight_n:.4g} N, the recipe says {stated_n:.4g} N"
            + (f": the forces look noted in {unit}" if unit else ""),
            "correct the unit of the forces in [columns], or the leg's mass_kg in [robot.legs]",
        )
    ]  # fmt: skip


@listed
def check_walking_cells(
    forces_n: FloatArray, cells: Sequence[str], foot: Sequence[str], log: str
) -> Iterator[Finding]:
    """Find cells under a walking robot that are dead or of turned sign in a log of that name.

    Parameters
    ----------
    forces_n
        By the calibration to start from, shape (n, c); NaN where a sample was lost.
    cells, foot
        Name and foot of every cell.
    """
    forces_n = forces_n[np.isfinite(forces_n).all(axis=1)]
    if not forces_n.size:
        return
    low, high = np.percentile(forces_n, [2, 98], axis=0)
    span = high - low
    for i, name in enumerate(cells):
        mates = [j for j in range(len(cells)) if foot[j] == foot[i] and j != i]
        if not mates or np.median(span[mates]) < WALKING_SPAN_N:
            continue
        if span[i] < DEAD_SHARE * float(np.median(span[mates])):
            yield Finding(
                "dead_cell", "alarm", name,
                f"the cell moves by {span[i]:.2g} N while the others of its foot move by "
                f"{float(np.median(span[mates])):.3g} N, in {log} (walk)",
                "check its wires, its plug and that it carries the plate",
            )  # fmt: skip
            continue
        others = np.abs(forces_n[:, mates] - np.median(low[mates])).sum(axis=1)
        # coarse converters repeat one reading: the percentile itself belongs to both sides
        down, up = others >= np.percentile(others, 70), others <= np.percentile(others, 30)
        steps = np.median(forces_n[down], axis=0) - np.median(forces_n[up], axis=0)
        usual = float(np.median(steps[mates]))
        if usual > WALKING_SPAN_N and steps[i] < -TURNED_SHARE * usual:
            yield Finding(
                "turned_sign", "alarm", name,
                f"the cell reads {-steps[i]:.3g} N less when its foot carries the robot; the "
                f"others read {usual:.3g} N more, in {log} (walk)",
                "check the sign of its scale and the wires of its bridge",
            )  # fmt: skip
