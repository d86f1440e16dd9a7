"""Six-axis legs, hanging and standing: opposite hangings, phases, contacts and the whole weight."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from footcal_cli.core.checks.lines import least_absolute
from footcal_cli.core.parameters import BoolArray, FloatArray
from footcal_cli.core.quality import Finding, listed

UNEQUAL = 0.15
"""Share by which the weight may differ between two axes: scales do by a few per cent."""
OPEN = 0.2
"""Share of the weight, or of its torque, by which offsets of two axes may differ: a tilt of 5°
makes 0.09."""
SHORT_LEVER_M = 0.03
"""A weight that hangs closer to its transducer has torques no larger than a drift."""
LONGEST_LEVER_M = 2.0
"""No leg's centre of mass lies further from its transducer."""
PHASE_SHARE, PHASE_OTHER = 0.3, 0.1
"""Shares of the torques' variance: explained as degrees from here on, and as radians up to here."""
UNLOADED_MOVES = 2.0
"""A leg in the air carries its own weight alone: its forces cannot change by more than this many
times what they change on the ground."""
FAINT = 0.2
"""Share of the usual leg's change of force below which a leg does not carry its part."""
NOT_CARRIED = 0.12
"""Share of the weight that a pose may lack: it stands still; scales and cables."""
FOLLOWS, FOLLOWS_NOT = 0.5, 0.2
"""Shares of the horizontal forces' variance that an attitude explains where it is read rightly, and
where it is not."""
_FEWEST_POSES, _FEWEST_ROWS = 12, 20
_FROZEN_POSES = 6


@listed
def check_hangings(leg: str, hung: Mapping[str, FloatArray]) -> Iterator[Finding]:
    """Compare opposite hangings of one leg: ``F(±a) = F₀ ± W a``, with one F₀ and one W for all.

    Parameters
    ----------
    hung
        Orientation (``+x`` …) -> wrenches, shape (n, 6), N and Nm.
    """
    whole = {name: rows[np.isfinite(rows).all(axis=1)] for name, rows in hung.items()}
    mean = {name: rows.mean(axis=0) for name, rows in whole.items() if len(rows)}
    axes = [a for a in "xyz" if {f"+{a}", f"-{a}"} <= set(mean)]
    half = {a: (mean[f"+{a}"] - mean[f"-{a}"]) / 2 for a in axes}
    middle = {a: (mean[f"+{a}"] + mean[f"-{a}"]) / 2 for a in axes}
    weight = {a: float(np.linalg.norm(half[a][:3])) for a in axes}
    if not axes or not max(weight.values()) > 0:
        return
    lever = float(np.median([np.linalg.norm(half[a][3:]) for a in axes])) / max(weight.values())
    if lever > LONGEST_LEVER_M:
        yield Finding(
            "torques_not_nm", "alarm", leg,
            f"its weight would act {lever:.3g} m away from the transducer: the torques look given "
            "in Nmm",
            'give the unit in [columns], tx_nm = { column = "…", unit = "N*mm" }',
        )  # fmt: skip
    if len(axes) < 2:
        return
    light, heavy = min(axes, key=weight.__getitem__), max(axes, key=weight.__getitem__)
    opened = max(
        float(np.linalg.norm(middle[a][:3] - middle[axes[0]][:3])) / max(weight.values())
        for a in axes[1:]
    )
    arm = max(max(float(np.linalg.norm(half[a][3:])) for a in axes), SHORT_LEVER_M * weight[heavy])
    twisted = max(float(np.linalg.norm(middle[a][3:] - middle[axes[0]][3:])) for a in axes[1:])
    if weight[light] < (1 - UNEQUAL) * weight[heavy]:
        yield Finding(
            "hangings_disagree", "warning", leg,
            f"it weighs {weight[light]:.3g} N along {light} and {weight[heavy]:.3g} N along "
            f"{heavy}, half the difference of opposite hangings",
            "look whether the leg touched something or was set to zero in one of them, whether its "
            "plug was another leg's, and for one axis in another unit",
        )  # fmt: skip
    elif max(opened, twisted / arm) > OPEN:
        of = "weight" if opened > OPEN else "weight's torque"
        yield Finding(
            "hangings_disagree", "warning", leg,
            f"offsets from opposite hangings differ by {100 * max(opened, twisted / arm):.0f} % of "
            f"its {of} between two axes",
            "look whether it was set to zero or touched something in one of them",
        )  # fmt: skip


@listed
def check_phase_unit(
    phase_rad: FloatArray, hung: FloatArray, part: FloatArray
) -> Iterator[Finding]:
    """Find phases that are degrees: a turning leg's torques follow ``cos φ`` and ``sin φ``.

    Parameters
    ----------
    phase_rad
        Of the legs, shape (n,).
    hung
        Torques, shape (n, 3).
    part
        Number of the leg and orientation of each row, shape (n,).
    """
    left = {1.0: 0.0, np.pi / 180: 0.0}
    whole = 0.0
    for one in np.unique(part):
        rows = (part == one) & np.isfinite(hung).all(axis=1) & np.isfinite(phase_rad)
        if rows.sum() < _FEWEST_ROWS or not np.ptp(phase_rad[rows]) > 0:
            continue
        centred = hung[rows] - hung[rows].mean(axis=0)
        centred = centred / np.maximum(centred.std(axis=0), 1e-12)
        whole += float((centred**2).sum())
        for factor in left:
            angle = factor * phase_rad[rows]
            waves = np.column_stack([np.ones(angle.size), np.cos(angle), np.sin(angle)])
            left[factor] += _unexplained(waves, centred)
    if not whole:
        return
    radians, degrees = (1 - left[factor] / whole for factor in left)
    if degrees > PHASE_SHARE and radians < PHASE_OTHER:
        yield Finding(
            "phase_not_radians", "alarm", "phase_rad",
            f"read as degrees the phases explain {100 * degrees:.0f} % of the torques' change, "
            f"as radians {100 * radians:.0f} %",
            'give the unit in [columns], phase_rad = { column = "…", unit = "deg" }',
        )  # fmt: skip


@listed
def check_poses(
    leg_names: tuple[str, ...],
    wrench: FloatArray,
    contact: BoolArray,
    up_b: FloatArray,
    world_up_b: FloatArray,
    weight_n: float | None,
) -> Iterator[Finding]:
    """Poses of a standing robot: each leg beside the others, and all together against the weight.

    The forces of all legs in the body frame add up to ``s₀ + G e`` with e the direction of gravity,
    s₀ the sum of the offsets and G the weight times the unit matrix, or nearly: a transducer's
    scales, or a left-handed frame.

    Parameters
    ----------
    leg_names
        Of the k legs.
    wrench
        In the body frame, shape (poses, k, 6), NaN where a leg was not recorded.
    contact
        Whether it stood, shape (poses, k); all true where unknown.
    up_b, world_up_b
        The world's upward axis in the body, ``Rᵀ z``, and the body's in the world, ``R z``,
        shape (poses, 3).
    """
    force = wrench[:, :, :3]
    yield from _frozen(leg_names, wrench)
    yield from _in_the_air(force, contact)
    moved = np.sqrt(np.nansum(np.nanvar(force, axis=0), axis=1))
    for k, name in enumerate(leg_names):
        usual = float(np.median(np.delete(moved, k))) if len(leg_names) > 2 else 0.0
        if moved[k] < FAINT * usual and contact[:, k].mean() > 0.5:
            yield Finding(
                "leg_does_not_carry", "warning", name,
                f"its force changes by {moved[k]:.3g} N from pose to pose, those of the others by "
                f"{usual:.3g} N",
                "check that it stood, and the unit of its forces (kgf are 9.8 times fewer)",
            )  # fmt: skip
    total = force.sum(axis=1)
    good = np.isfinite(total).all(axis=1) & np.isfinite(up_b).all(axis=1)
    if good.sum() >= _FEWEST_POSES and weight_n:
        yield from _whole_weight(total[good], up_b[good], world_up_b[good], weight_n)


def _frozen(names: tuple[str, ...], wrench: FloatArray) -> Iterator[Finding]:
    same = (wrench[1:] == wrench[:-1]).all(axis=2)
    longest = [_longest(same[:, k]) + 1 for k in range(len(names))]
    for name, run in zip(names, longest, strict=True):
        if run >= _FROZEN_POSES and run > 4 * float(np.median(longest)):
            yield Finding(
                "stuck_channel", "alarm", name,
                f"all six readings are the same in {run} poses in a row",
                "check that the transducer is connected and that its reading is refreshed",
            )  # fmt: skip


def _longest(flags: BoolArray) -> int:
    run = best = 0
    for flag in flags:
        run = run + 1 if flag else 0
        best = max(best, run)
    return best


def _in_the_air(force: FloatArray, contact: BoolArray) -> Iterator[Finding]:
    """Legs that change their forces more in the air than on the ground."""
    spread = []
    for state in (False, True):
        each = [force[contact[:, k] == state, k] for k in range(force.shape[1])]
        deviations = [f - np.nanmean(f, axis=0) for f in each if len(f) > 1]
        if not deviations:
            return
        spread.append(float(np.sqrt(np.nanmean(np.concatenate(deviations) ** 2))))
    if spread[0] > UNLOADED_MOVES * spread[1]:
        yield Finding(
            "contact_inverted", "alarm", "contact",
            f"forces of legs in the air change by {spread[0]:.3g} N, on the ground by "
            f"{spread[1]:.3g} N",
            "contact is 1 on the ground; turn the column round",
        )  # fmt: skip


def _whole_weight(
    total: FloatArray, up_b: FloatArray, world_up_b: FloatArray, weight_n: float
) -> Iterator[Finding]:
    design = np.column_stack([np.ones(len(total)), up_b])
    beyond = np.column_stack([least_absolute(design, axis) for axis in total.T])
    off = np.einsum("ij,ij->i", beyond, up_b) / weight_n
    wrong = np.abs(off) > NOT_CARRIED
    if wrong.any():
        worst = int(np.argmax(np.abs(off)))
        yield Finding(
            "weight_not_constant", "warning", "all legs",
            f"in {int(wrong.sum())} of {off.size} poses the legs together carry up to "
            f"{100 * abs(off[worst]):.0f} % of the weight {'less' if off[worst] < 0 else 'more'} "
            "than in the others",
            "look whether something else carried the robot, and whether all legs have one unit",
        )  # fmt: skip
        return
    given = _explained(total, up_b)
    others = {"the other way round (world to body)": _explained(total, world_up_b)}
    for shift in (-2, -1, 1, 2):
        first, last = max(shift, 0), len(total) + min(shift, 0)
        value = _explained(total[first:last], up_b[first - shift : last - shift])
        others[f"shifted by {abs(shift)} {'pose' if abs(shift) == 1 else 'poses'}"] = value
    best = max(others, key=others.__getitem__)
    if others[best] > FOLLOWS and given < FOLLOWS_NOT:
        yield Finding(
            "attitudes_wrong", "alarm", "body_qx …",
            f"attitudes explain {100 * given:.0f} % of the change of the horizontal forces; read "
            f"{best}, {100 * others[best]:.0f} %",
            "give attitudes of the body in the world, each with the forces of its own pose",
        )  # fmt: skip


def _explained(total: FloatArray, up_b: FloatArray) -> float:
    """Share of the horizontal force's variance that follows gravity, the larger of two axes."""
    shares = []
    for axis in (0, 1):
        target = total[:, axis] - total[:, axis].mean()
        design = np.column_stack([np.ones(len(up_b)), up_b[:, axis]])
        shares.append(1.0 - _unexplained(design, target[:, None]) / float(target @ target))
    return max(shares)


def _unexplained(design: FloatArray, target: FloatArray) -> float:
    solved = np.linalg.lstsq(design, target, rcond=None)[0]
    return float(((target - design @ solved) ** 2).sum())
