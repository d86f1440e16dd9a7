"""Standing calibrations as tables, error rows and sentences."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Literal

import numpy as np

from footcal_cli.core.hang.model import AXES
from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.pose.common import common_shift, common_turn
from footcal_cli.core.pose.data import PoseData
from footcal_cli.core.pose.departures import Departure
from footcal_cli.core.pose.hanging import LegKnowledge
from footcal_cli.core.pose.joint import PoseFit
from footcal_cli.core.pose.leg_map import LegMap
from footcal_cli.core.pose.selection import Candidate
from footcal_cli.core.pose.slow_noise import SlowNoise
from footcal_cli.core.pose.standing import OffsetFit
from footcal_cli.core.spatial import rotation_log, wrench_transform
from footcal_cli.records.results import FindingRecord, RmseRow, VerdictRecord
from footcal_cli.report import Sheet, number, with_sd

_SUSPECT_P = 1e-4
_SUSPECT_SHARE = 0.1
_NOISY = 1.5
_BELIEF = {"robot.weight": "the recipe's mass"}
"""Who believed in a quantity before the poses; all others are known from hanging."""
_MOST_DEPARTURES = 4
"""So many contradictions are told; they have one cause, mostly."""


def rmse_rows(stages: Mapping[str, FloatArray], held_out: Candidate) -> tuple[RmseRow, ...]:
    """Per stage: sum of forces and of moments, per axis RMS; held-out errors of the fit."""
    rows = [
        _row(quantity, unit, stage, part)
        for stage, error in stages.items()
        for quantity, unit, part in (
            ("sum of forces", "N", error[:, :3]),
            ("sum of moments", "Nm", error[:, 3:]),
        )
    ]
    samples = 3 * next(iter(stages.values())).shape[0]
    for quantity, unit, square in (
        ("sum of forces", "N", held_out.cv_square[:3]),
        ("sum of moments", "Nm", held_out.cv_square[3:]),
    ):
        rows.append(
            RmseRow(
                quantity=quantity,
                unit=unit,
                stage="joint" if "joint" in stages else "after",
                reference="chassis weight",
                split="held_out",
                rmse=float(np.sqrt(square.mean())),
                n=samples,
            )
        )
    return tuple(rows)


def _row(quantity: str, unit: str, stage: str, error: FloatArray) -> RmseRow:
    return RmseRow(
        quantity=quantity, unit=unit, stage=stage, reference="chassis weight", split="all",
        rmse=_rms(error), n=int(error.size),
    )  # fmt: skip


def _rms(values: FloatArray) -> float:
    return float(np.sqrt(np.mean(np.square(values))))


def verdict(
    fit: PoseFit,
    stages: Mapping[str, FloatArray],
    mapped: LegMap,
    held_out: Candidate,
    best: Candidate,
    slow: SlowNoise,
    contradicted: Sequence[Departure],
) -> VerdictRecord:
    """One sentence: what the sum of forces was off by, and is now on poses not used."""
    before = _rms(stages["before"][:, :3])
    alternated = bool(np.isnan(fit.covariance).any())
    after = _rms(stages["after"][:, :3]) if alternated else _held_out(held_out, 0)
    moment = _rms(stages["after"][:, 3:]) if alternated else _held_out(held_out, 3)
    turn = np.rad2deg(np.linalg.norm(rotation_log(fit.mounting.turn_b), axis=1))
    details = [
        f"Mounting errors fitted: {fit.options.structure.value}; rotations up to "
        f"{number(float(turn.max()), 2)}° ({fit.geometry.legs[int(turn.argmax())]}).",
        f"The evidence alone asks for: {best.structure.value}.",
        f"Moments: {number(_rms(stages['before'][:, 3:]), 2)} Nm before, "
        f"{number(moment, 2)} Nm now.",
        *common_words(fit),
        *slow_words(slow),
    ]
    suspects = suspect_legs(mapped, fit.geometry.legs)
    if not fit.converged:
        return VerdictRecord(
            level="bad", sentence="The fit did not converge.", details=tuple(details)
        )
    sentence = (
        f"The sum of forces on {fit.poses} poses is off by {number(after, 2)} N per axis"
        f"{'' if alternated else ' on poses not used for the fit'} ({number(before, 2)} N with a "
        "tare in the air)."
    )
    if suspects:
        return VerdictRecord(
            level="warning",
            sentence=f"{sentence} Leg {', '.join(suspects)} does not fit the others.",
            details=tuple(details),
        )
    if contradicted:
        names = {_BELIEF.get(one.name, "hanging") for one in contradicted}
        sentence = f"{sentence} The poses contradict {' and '.join(sorted(names))}."
    noisy = fit.options.noise_known and fit.noise_factor > _NOISY
    if noisy:
        details.insert(
            0, f"The balance is {fit.noise_factor:.1f} times noisier than the sensors are said to "
            "be: something is not in the model; run diagnose.",
        )  # fmt: skip
    return VerdictRecord(
        level="warning" if noisy or contradicted else "good",
        sentence=sentence,
        details=tuple(details),
    )


def _held_out(candidate: Candidate, first: int) -> float:
    """Held-out error per axis of the forces (0) or the moments (3)."""
    return float(np.sqrt(candidate.cv_square[first : first + 3].mean()))


def common_words(fit: PoseFit) -> tuple[str, ...]:
    """What all legs share is seen worst: a common yaw and a common height."""
    yaw, height = _common_sd(fit, 2), _common_sd(fit, 3 * len(fit.geometry.legs) + 2)
    if np.isnan(yaw):
        return ("This method gives no intervals.",)
    words = []
    if fit.options.structure.rotates:
        words.append(f"A yaw common to all transducers is known to ± {np.rad2deg(yaw):.2g}°")
    words.append(f"a height common to all hips to ± {1e3 * height:.2g} mm")
    return (f"{'; '.join(words)} (one sd); tilt the body more to see them better.",)


def slow_words(slow: SlowNoise) -> tuple[str, ...]:
    """What of the noise lasts from pose to pose, where any does."""
    if slow.share == 0.0:
        return ()
    return (
        f"{100 * slow.share:.0f} % of the noise's variance is drift that lasts about "
        f"{slow.memory_poses:.0f} poses; the intervals allow for it.",
    )


def _common_sd(fit: PoseFit, first: int) -> float:
    """Sd of the mean over legs of one body axis' rotation or shift."""
    legs = len(fit.geometry.legs)
    at = first + 3 * np.arange(legs)
    return float(np.sqrt(fit.covariance[np.ix_(at, at)].sum())) / legs


def suspect_legs(mapped: LegMap, legs: Sequence[str]) -> list[str]:
    """Legs whose own readings predict the residual, the worst one only."""
    found = [
        (share, leg)
        for leg, share, p in zip(legs, mapped.share, mapped.p, strict=True)
        if p < _SUSPECT_P and share > _SUSPECT_SHARE
    ]
    return [max(found)[1]] if found else []


def mounting_sheet(fit: PoseFit) -> Sheet:
    """Mounting errors along the nominal transducer's axes."""
    estimates = fit.estimates()
    rows = []
    for leg in fit.geometry.legs:
        cells = [
            with_sd(
                factor * estimates[f"{leg}.{kind}_{axis}"],
                factor * estimates.sd_of(f"{leg}.{kind}_{axis}"),
            )
            for kind, factor in (("mount_rot", 180.0 / np.pi), ("mount_pos", 1e3))
            for axis in "xyz"
        ]
        rows.append((leg, *cells))
    return Sheet(
        "Mounting errors",
        ("leg", "turn x (°)", "turn y (°)", "turn z (°)", "shift x (mm)", "shift y (mm)",
         "shift z (mm)"),
        rows,
        note="Along the nominal transducer's axes, ± one standard deviation. A shift is the hip's "
        "minus the chassis CoM's: standing shows only their sum (p̃ + p_BC in Wu & Revzen).",
    )  # fmt: skip


def candidate_sheet(candidates: Sequence[Candidate]) -> Sheet:
    """Table I with a fifth model and both ways of counting."""
    best = min(candidate.bic for candidate in candidates)
    return Sheet(
        "Which mounting errors are there",
        ("free", "DOF", "held-out error", "held-out χ²", "BIC as printed", "BIC above best"),
        [
            (
                candidate.structure.value,
                str(candidate.freedom),
                number(candidate.cv_error, 3),
                number(candidate.cv_chi2, 3),
                f"{candidate.bic_paper:.0f}",
                f"{candidate.bic - best:.0f}",
            )
            for candidate in candidates
        ],
        note="Cross-validation by pose block, squared error per pose: in the paper's norm, and in "
        "units of the noise (6 if all is explained). The printed BIC counts P residuals though "
        "there are 6 P; the last one counts all, in units of the noise, hanging logs included. The "
        "evidence decides on rotations; translations it does not demand keep their prior.",
    )  # fmt: skip


def common_sheet(fit: PoseFit) -> Sheet:
    """What only the legs together share."""
    legs = len(fit.geometry.legs)
    rows = [
        (name, axis, number(factor * _common_sd(fit, first + i), 2), unit)
        for name, first, factor, unit in (
            ("common turn", 0, 180.0 / np.pi, "°"),
            ("common shift", 3 * legs, 1e3, "mm"),
        )
        for i, axis in enumerate("xyz")
    ]
    return Sheet(
        "How well common errors are seen",
        ("error", "body axis", "sd", "unit"),
        rows,
        note=f"The poses alone determine {fit.rank} of {fit.free} directions.",
    )


def prior_sheet(fit: PoseFit, legs: Sequence[LegKnowledge]) -> Sheet:
    """How far offsets and weights moved from the hanging logs, in their own sd."""
    rows = []
    for k, (name, leg) in enumerate(zip(fit.geometry.legs, legs, strict=True)):
        sd = np.sqrt(np.diag(leg.covariance)[:7])
        pull = (np.append(fit.mounting.offset[k], fit.mounting.leg_weight_n[k])
                - np.append(leg.offset, leg.weight_n)) / sd  # fmt: skip
        rows.append((name, *(number(float(value), 2) for value in pull)))
    return Sheet(
        "Pull on the hanging calibration",
        ("leg", *AXES, "weight"),
        rows,
        note="Shift of offset and weight by the poses in units of their hanging sd: beyond ± 3 "
        "something changed between hanging and standing.",
    )


def findings(fit: PoseFit, mapped: LegMap) -> tuple[FindingRecord, ...]:
    """A leg that does not fit, poses that do not suffice, a turn that all mountings share."""
    found = [
        FindingRecord(
            code="leg_predicts_residual",
            severity="warning",
            where=f"leg {leg}",
            sentence=f"its own readings predict {100 * mapped.share[k]:.0f} % of "
            "the residual of the balance",
            remedy="check gain, axes and channels of that transducer; run diagnose",
        )
        for k, leg in enumerate(fit.geometry.legs)
        if leg in suspect_legs(mapped, fit.geometry.legs)
    ]
    if fit.rank < fit.free:
        found.append(
            FindingRecord(
                code="rank",
                severity="warning",
                where=f"{fit.poses} poses",
                sentence=f"they determine {fit.rank} of {fit.free} mounting errors; the rest rests "
                "on priors and hanging logs",
                remedy="add poses with other shaft angles and body tilts (8 suffice for full rank)",
            )
        )
    common = common_turn(rotation_log(fit.mounting.turn_b))
    if common is not None and common.stands_out:
        found.append(
            FindingRecord(
                code="mountings_turned_alike",
                severity="note",
                where="all legs",
                sentence=f"{common.words}; a body frame tilted by its markers (body_tilt) looks "
                "the same in every pose (mount_rotation)",
                remedy="put a spirit level on the chassis where the markers define its frame",
            )
        )
    return (*found, *_com_elsewhere(fit))


def _com_elsewhere(fit: PoseFit) -> tuple[FindingRecord, ...]:
    """A shift that all hips share is named as that of the chassis' CoM."""
    geometry, hip_sd = fit.geometry, fit.options.translation_sd_m
    if not np.isfinite(hip_sd) or np.isnan(fit.covariance).any():
        return ()
    legs = len(geometry.legs)
    of_mean = np.kron(np.ones((1, legs)) / legs, np.eye(3))
    own = slice(3 * legs, 6 * legs)
    shift = fit.arm_b_m - (geometry.hip_b_m - geometry.chassis_com_b_m)
    shared = common_shift(
        shift, of_mean @ fit.covariance[own, own] @ of_mean.T, hip_sd,
        min(fit.options.com_sd_m, 10.0),
    )  # fmt: skip
    if not shared.stands_out:
        return ()
    where = ", ".join(
        with_sd(1e3 * value, 1e3 * sd)
        for value, sd in zip(geometry.chassis_com_b_m + shared.com_b_m, shared.sd_m, strict=True)
    )
    metres = ", ".join(f"{v:.4f}" for v in geometry.chassis_com_b_m + shared.com_b_m)
    return (
        FindingRecord(
            code="chassis_com_elsewhere",
            severity="note",
            where="all legs",
            sentence="all hips are shifted alike, as if the CoM of the robot without its legs lay "
            f"at ({where}) mm in the body frame; standing shows only hip minus CoM",
            remedy=f"write chassis_com_m = [{metres}] into [pose_calib] if the CoM was not "
            "measured: the shifts are then each hip's own",
        ),
    )


def departure_findings(found: Sequence[Departure]) -> tuple[FindingRecord, ...]:
    """Where the poses contradict the scale or the hanging robot."""
    findings = []
    for one in found[:_MOST_DEPARTURES]:
        of_robot = one.name == "robot.weight"
        said = _BELIEF.get(one.name, "hanging")
        findings.append(
            FindingRecord(
                code="robot_weight_differs" if of_robot else "differs_from_hanging",
                severity="warning",
                where=one.name,
                sentence=f"the poses say {with_sd(one.found, one.found_sd)} {one.unit}, {said} "
                f"{with_sd(one.believed, one.believed_sd)} {one.unit}: {one.sigmas:.0f} sd apart",
                remedy="weigh the robot as it stood, with battery and cables; if the scale is "
                "right, the transducers' gain is off"
                if of_robot
                else "hang the robot again and compare; an offset that moved since asks for "
                "--fit offsets",
            )
        )
    return tuple(findings)


def disagreeing_directions(fit: PoseFit) -> FindingRecord:
    """The hanging logs of different legs do not belong to one rigid robot."""
    return FindingRecord(
        code="hang_directions_disagree",
        severity="warning",
        where="hanging logs",
        sentence="the legs' directions of gravity do not fit one rigid robot (χ² "
        f"{fit.chi2_hang:.0f}); they are not used for the mounting",
        remedy="hang the whole robot at once for all legs, or check the transducers' axes "
        "(orientation_of in hang-calib)",
    )


def offset_sentence(found: OffsetFit, legs: Sequence[str]) -> str:
    """One sentence for the verdict of an offset run."""
    if not found.accepted:
        return (
            f"Offsets cannot be had from these poses: only {found.rank} of {found.unknowns} "
            "directions are seen."
        )
    leg, axis = divmod(int(np.argmax(np.abs(found.change[:, :3]))), 3)
    worst_sd = float(found.offset_sd[:, :3].max())
    return (
        f"All offsets found again from {found.poses} poses, ± {number(worst_sd, 2)} N or better; "
        f"the largest change is {number(float(found.change[leg, axis]), 3)} N "
        f"({legs[leg]} {AXES[axis]})."
    )


def offset_level(found: OffsetFit) -> Literal["good", "warning", "bad"]:
    """Refused, too few poses for the asked precision, or good."""
    if not found.accepted:
        return "bad"
    return "good" if len(found.words) == 1 else "warning"


def offset_sheet(found: OffsetFit, legs: Sequence[str]) -> Sheet:
    """New offsets and their change."""
    rows = []
    for k, leg in enumerate(legs):
        rows.append(
            (leg, "offset", *(_maybe(found.offset, found.offset_sd, k, i) for i in range(6)))
        )
        rows.append(
            (leg, "change", *(_maybe(found.change, found.change_sd, k, i) for i in range(6)))
        )
    return Sheet(
        "Offsets from standing",
        ("leg", "", "fx (N)", "fy (N)", "fz (N)", "tx (mNm)", "ty (mNm)", "tz (mNm)"),
        rows,
        note="± one standard deviation; lifted in "
        + ", ".join(f"{leg} {int(n)}" for leg, n in zip(legs, found.lifted, strict=True))
        + f" of {found.poses} poses.",
    )


def _maybe(values: FloatArray, sd: FloatArray, leg: int, axis: int) -> str:
    """A force in N or a torque in mNm with its sd; a dash where it is not seen."""
    if np.isnan(values[leg, axis]):
        return "–"
    factor = 1.0 if axis < 3 else 1e3
    return with_sd(factor * float(values[leg, axis]), factor * float(sd[leg, axis]))


def offset_rmse(
    data: PoseData,
    rot_bt: FloatArray,
    arm_b_m: FloatArray,
    legs: Sequence[LegKnowledge],
    offset: FloatArray,
    stage: str,
) -> tuple[RmseRow, ...]:
    """Balance errors with given offsets."""
    applied = data.wrench_t - offset
    total = np.einsum("kij,pkj->pi", wrench_transform(rot_bt, arm_b_m), applied)
    chassis_n = data.robot_weight_n - sum(leg.weight_n for leg in legs)
    total[:, :3] += chassis_n * data.gravity_b
    return (
        _row("sum of forces", "N", stage, total[:, :3]),
        _row("sum of moments", "Nm", stage, total[:, 3:]),
    )


def footer(method: str, balance: str, errors_in_variables: bool) -> tuple[str, ...]:
    """How it was computed."""
    if method == "alternating":
        form = "as printed (fixed CoM)" if balance == "printed" else "exact chassis balance"
        return (
            f"Alternating least squares of Wu & Revzen, eqs. (8) and (9), {form}; no intervals.",
        )
    eiv = "noise of the wrenches compensated" if errors_in_variables else "plain least squares"
    return (
        f"Chassis balance, joint Levenberg-Marquardt on the Gram matrix of the poses, {eiv}; "
        "offsets, weights and directions of gravity with their joint covariance from hanging "
        "(Wu & Revzen, eqs. (8) and (9), in the form in which no leg CoM enters).",
    )
