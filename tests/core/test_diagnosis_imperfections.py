"""What every log has is fitted beside all causes, unless it is far larger than usual."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.stats import norm

from footcal_cli.core.chain import Chain, Link
from footcal_cli.core.diagnosis.bridge import problem_from
from footcal_cli.core.diagnosis.imperfections import (
    LIMIT,
    _as_vectors,
    _large_elsewhere,
    masses_found,
    moving_masses,
    sizes_of_imperfections,
)
from footcal_cli.core.diagnosis.investigation import investigate
from footcal_cli.core.diagnosis.signals import describe
from footcal_cli.core.effects import TABLE
from footcal_cli.core.effects.calibration import AXES, OFFSET
from footcal_cli.core.effects.six_axis import SCALE_MATRIX
from footcal_cli.core.effects.usual import LIMB_SWING
from footcal_cli.core.experiments import stand
from footcal_cli.core.inference import grams
from footcal_cli.core.inference.case import Case, rows_of
from footcal_cli.core.inference.problem import Problem, Signature
from footcal_cli.core.inference.signatures import LibraryColumns
from footcal_cli.core.log import Log
from footcal_cli.core.parameters import Parameter, ParameterSet
from tests.core.test_diagnosis_bridge import Hidden, walk_case

BLOCKS, ROWS, RATE_HZ = 12, 200, 50.0
USUAL_S = 0.002
FAR_S = (-0.1, -0.05, 0.05, 0.1)


def gait(late_s: float) -> np.ndarray:
    """A load that steps twice a second with three harmonics, and may be late."""
    time = np.arange(BLOCKS * ROWS) / RATE_HZ - late_s
    return sum(np.sin(2 * np.pi * 2.0 * k * time + k) / k for k in (1, 2, 3))  # type: ignore[return-value]


def late_by(seconds: float) -> tuple[Problem, LibraryColumns, np.ndarray, list[Signature]]:
    """A residual of a stream that is so late, with columns of a usual delay and of far ones."""
    rng = np.random.default_rng(3)
    block = np.repeat(np.arange(BLOCKS), ROWS)
    usual = gait(USUAL_S) - gait(0.0)
    signature = Signature("delay", "delay", "robot", "s", (), -0.5, 0.5)
    near = Signature("delay", "delay", "robot", "s", (), -USUAL_S, USUAL_S)
    columns = tuple((gait(by) - gait(0.0)) / by for by in FAR_S)
    problem = Problem(
        residual=gait(seconds) - gait(0.0) + 0.2 * rng.standard_normal(block.size),
        calibration=np.ones((block.size, 1)),
        columns=np.empty((block.size, 0)),
        signatures=(),
        block=block,
        output=np.zeros(block.size, dtype=np.int64),
        sequence=block,
        outputs=("fz",),
        units=("N",),
        noise=np.full(block.size, 1.0),
        tolerance=np.array([0.1]),
        rate_hz=RATE_HZ,
    )
    library = LibraryColumns((signature,) * len(FAR_S), columns, ())
    return problem, library, usual[:, None], [near]


@pytest.mark.parametrize(
    ("seconds", "large"),
    [
        (0.0, set()),
        (0.001, set()),
        (-0.004, set()),
        # a fifth of a period late: no gradient at none leads there
        (0.1, {"delay"}),
        (-0.1, {"delay"}),
    ],
)
def test_a_delay_far_beyond_the_usual_ones_stays_a_candidate(
    seconds: float, large: set[str]
) -> None:
    assert _large_elsewhere(*late_by(seconds)) == large


def test_only_the_usual_sizes_of_an_effect_are_fitted_and_the_others_stay_causes() -> None:
    """A CAD model puts the CoM off along the floor; how high it is, is a cause as any other."""
    case = walk_case(3, duration_s=30.0)
    problem = problem_from(case, rows_of(case), TABLE.values(), describe)
    assert {s.parameter for s in problem.usual_of if s.effect == "com_offset"} == {
        "com_correction_x", "com_correction_y"
    }  # fmt: skip
    assert {s.parameter for s in problem.signatures if s.effect == "com_offset"} == {
        "com_correction_z"
    }
    assert "com_offset" not in {e.effect for e in problem.excluded}
    assert "delay" in {e.effect for e in problem.excluded}


def test_a_height_of_the_com_and_a_gain_of_its_acceleration_are_one_set() -> None:
    """``p = c − z c̈ / (g + z̈)``: at one height both make the same lever longer."""
    higher: Hidden = ("com_offset", {"robot": ("robot",)}, {"robot.com_correction_z": 0.03})
    found = investigate(walk_case(4, higher, duration_s=30.0), TABLE, describe)
    assert len(found.found) == 1
    cause = found.found[0].cause
    named = {cause.signature.effect, *(rival.effect for rival in cause.rivals)}
    assert named >= {"com_offset", "accel_gain"}


def without_limbs(log: Log, share: float) -> Log:
    """A log that leaves out ``(L̇ʸ, −L̇ˣ) = s m cᶻ c̈`` and says that it knows no L̇."""
    known = log.known
    acc, lever = known["com_acc_mps2"], known["mass_kg"] * known["com_m"][:, 2]
    limbs = share * lever[:, None] * np.stack([-acc[:, 1], acc[:, 0]], axis=1)
    return log.with_known(
        angmom_rate_nm=known["angmom_rate_nm"] - limbs, angmom_missing=np.ones(len(log))
    )


def test_limbs_that_swing_as_the_body_is_pushed_are_fitted_where_no_log_has_them() -> None:
    case, share = walk_case(3, duration_s=30.0), -0.15
    swung = replace(case, logs=tuple(without_limbs(log, share) for log in case.logs))
    clean, problem = (problem_from(c, rows_of(c), TABLE.values(), describe) for c in (case, swung))
    assert "limb_swing" not in {s.effect for s in clean.usual_of}
    at = [i for i, s in enumerate(problem.usual_of) if s.effect == "limb_swing"]
    bare = problem.without_usual({s.effect for s in problem.usual_of}).without_candidates
    assert problem.usual is not None
    # alone, for what repeats with the gait would take some of it
    size, sd = sizes_of_imperfections(replace(bare, usual=problem.usual[:, at]))
    found = 0.2 * size  # in usual sizes
    assert found == pytest.approx([share, share], abs=0.03)
    assert np.all(0.2 * sd < 0.02)


def test_what_limbs_add_is_taken_back() -> None:
    (log,) = walk_case(3, duration_s=30.0).logs
    log = log.with_known(angmom_missing=np.ones(len(log)))
    chain = Chain((Link(LIMB_SWING, {"robot": ("robot",)}),))
    values = {"robot.limb_swing_x": 0.3, "robot.limb_swing_y": -0.2}
    shown = chain.apply(log, values)[0]
    assert np.abs(shown.known["angmom_rate_nm"] - log.known["angmom_rate_nm"]).max() > 0.1
    back = chain.remove(shown, values)[0]
    np.testing.assert_allclose(
        back.known["angmom_rate_nm"], log.known["angmom_rate_nm"], atol=1e-12
    )


def plates_case(gain: float) -> Case:
    """A stand of two transducers whose fz share the weight; the second reads too much by `gain`."""
    rng, n, legs = np.random.default_rng(8), 1200, ("a", "b")
    share = np.repeat(np.where(np.arange(12) % 4 == 3, 0.0, rng.uniform(0.3, 0.7, 12)), n // 12)
    load = 400.0 * np.column_stack([share, 1.0 - share])
    wrench = np.zeros((n, 2, 6))
    wrench[:, :, 2] = load * [1.0, 1.0 + gain]
    wrench += rng.normal(0.0, 1.0, wrench.shape) * ([0.2] * 3 + [0.01] * 3)
    places = np.broadcast_to([[0.0, 0.1, 0.0], [0.0, -0.1, 0.0]], (n, 2, 3))
    com = np.einsum("nf,nfk->nk", load / 400.0, places) + np.array([0.0, 0.0, 0.4])
    turned = np.broadcast_to(np.eye(3), (n, 2, 3, 3))
    known = {
        "com_m": com, "com_acc_mps2": np.zeros((n, 3)), "angmom_rate_nm": np.zeros((n, 2)),
        "mass_kg": np.full(n, 400.0 / 9.8), "gravity_mps2": np.full(n, 9.8),
        "contact": (load > 0.0).astype(float), "feet_m": places, "foot_pos_m": places,
        "foot_rot_wt": turned, "foot_acc_mps2": np.zeros((n, 2, 3)),
        "foot_weight_n": np.zeros((n, 2)), "foot_com_m": np.zeros((n, 2, 3)),
        "feet_yaw_rad": np.zeros((n, 2)),
    }  # fmt: skip
    channels = tuple(f"{leg}.{axis}" for leg in legs for axis in AXES)
    block = np.repeat(np.arange(12), n // 12)
    log = Log("stand", channels, np.arange(n) / 100.0, wrench.reshape(n, 12), known, block)
    names = [f"{leg}.offset_{axis}" for leg in legs for axis in AXES]
    return Case(
        stand.ON_SIX_AXIS, (log,), Chain((Link(OFFSET, {leg: (leg,) for leg in legs}),)),
        dict.fromkeys(names, 0.0),
        ParameterSet(tuple(Parameter(name, "N", 0.0, scale=1.0) for name in names)),
        tolerance_n=0.4, tolerance_nm=0.4, alike=False, pieces=True,
    )  # fmt: skip


@pytest.mark.parametrize(("gain", "usual"), [(0.004, True), (0.05, False)])
def test_a_gain_that_a_data_sheet_allows_is_usual_and_a_larger_one_a_cause(
    gain: float, usual: bool
) -> None:
    case = plates_case(gain)
    problem = problem_from(case, rows_of(case), TABLE.values(), describe)
    assert ("scale_matrix" in {s.effect for s in problem.usual_of}) == usual
    assert (("scale_matrix", "gain_fz") in {s.cause[:2] for s in problem.signatures}) != usual


def test_the_gain_of_the_other_leg_stays_usual_beside_a_cause() -> None:
    case = plates_case(0.05)
    chain = case.chain.with_link(Link(SCALE_MATRIX, {"b": ("b",)}))
    values = {**case.values, **{f"b.{p.name}": p.neutral for p in SCALE_MATRIX.parameters}}
    named = replace(case, chain=chain, values={**values, "b.gain_fz": 0.05})
    problem = problem_from(named, rows_of(named), TABLE.values(), describe)
    gains = {s.where for s in problem.usual_of if s.effect == "scale_matrix"}
    assert gains == {"a"}


@pytest.mark.parametrize("pieces", [True, False])
def test_what_is_bounded_is_known_to_its_usual_size(*, pieces: bool) -> None:
    """In stands and walks; not the mass, which nothing bounds."""
    names = ("scale_matrix", "mass", "mount_translation")
    problem: Any = SimpleNamespace(
        pieces=pieces, usual_columns=slice(1, 4), usual_of_any_size=frozenset({"mass"}),
        usual_of=tuple(Signature(name, name, "left", "-") for name in names),
    )  # fmt: skip
    shared = np.arange(20, 25)  # one that is held, three usual ones, one accepted
    assert grams._of_usual_size(problem, shared).tolist() == [21, 23]


def test_what_one_stance_alone_tells_of_a_calibration_is_taken_out_of_it() -> None:
    """A sum that all stances show stays; a difference that only the last one shows goes there."""
    block = np.repeat(np.arange(4), 6)
    both, left = np.ones(24), np.where(block == 3, np.tile([1.0, 0.0], 12), 0.5)
    rows = np.column_stack([both, left, np.random.default_rng(0).standard_normal(24)])
    kept, columns = np.arange(24), np.arange(2)
    raw, white = grams._without_known_to_one(rows, rows, block, kept, columns)
    np.testing.assert_allclose(white[:18], rows[:18])
    difference = (left - 0.5 * both)[18:]
    np.testing.assert_allclose(difference @ white[18:], 0.0, atol=1e-9)
    np.testing.assert_allclose(raw, white)
    seen = rows.copy()
    seen[:6, 1] = np.tile([1.0, 0.0], 3)  # another stance shows it too
    again, _ = grams._without_known_to_one(seen, seen, block, kept, columns)
    np.testing.assert_allclose(again, seen)


@pytest.mark.parametrize(("angle", "far"), [(0.0, 6.0), (0.8, 6.0), (0.8, 3.0)])
def test_an_offset_along_the_diagonal_is_as_far_as_one_along_an_axis(
    angle: float, far: float
) -> None:
    """√Σ s² of two components against what two Gaussians exceed as rarely as one its limit."""
    owners = (("robot", ("robot",)),)
    signatures = [
        Signature("com_offset", f"com_correction_{a}", "robot", "m", (), -1.0, 1.0, owners)
        for a in "xy"
    ]
    size, limit = far * np.array([np.cos(angle), np.sin(angle)]), np.full(2, LIMIT)
    beyond = _as_vectors(size, np.full(2, 0.2), limit, signatures)
    assert bool(beyond.max() > 1.0) is (far > 5.0)
    draws = np.random.default_rng(1).standard_normal((200_000, 2))
    rare = np.mean(np.linalg.norm(draws, axis=1) > far / beyond.max() - 0.4 / beyond.max())
    assert rare == pytest.approx(2.0 * norm.sf(LIMIT), abs=1e-4)


@pytest.mark.parametrize(("right_kg", "severity"), [(1.4, "warning"), (0.62, "note"), (None, "")])
def test_masses_below_the_cells_are_said_and_feet_that_differ_are_warned_of(
    right_kg: float | None, severity: str
) -> None:
    case = walk_case(5, duration_s=30.0)
    feet = ("left", "right")
    plates = {"left": 0.6, "right": right_kg} if right_kg else {}
    logs = []
    for log in case.logs:
        rng = np.random.default_rng(6)
        readings = log.readings.copy()
        acc = np.zeros((len(log), 2, 3))
        for i, foot in enumerate(feet):
            air = log.known["contact"][:, i] == 0.0
            acc[air, i, 2] = 6.0 * np.sin(0.37 * np.arange(int(air.sum()))) + 0.1 * (
                rng.standard_normal(int(air.sum()))
            )
            own = [k for k, c in enumerate(log.channels) if c.startswith(foot)]
            mass = plates.get(foot, 0.0) or 0.0
            scale = np.array([case.values[f"{log.channels[k]}.scale"] for k in own])
            readings[:, own] -= mass * acc[:, i, 2:] / len(own) / scale
        logs.append(replace(log, readings=readings).with_known(foot_acc_mps2=acc))
    case = replace(case, logs=tuple(logs))
    problem = problem_from(case, rows_of(case), TABLE.values(), describe)
    said = list(masses_found(problem))
    assert [one.severity for one in said] == ([severity] if severity else [])
    if severity:
        found = moving_masses(problem)
        assert found["right"][0] == pytest.approx(right_kg, abs=0.1)
        assert ("the feet differ" in said[0].sentence) == (severity == "warning")
