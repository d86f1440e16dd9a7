"""What a walk asks of the diagnosis: whole offsets, a-priori aliases, losses in one noise."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter

from footcal_cli.core.chain import Chain, Link
from footcal_cli.core.contact import airborne
from footcal_cli.core.diagnosis.aliases import aliases
from footcal_cli.core.diagnosis.answer import Verdict
from footcal_cli.core.diagnosis.bridge import problem_from
from footcal_cli.core.diagnosis.comparison import never_distinguished
from footcal_cli.core.diagnosis.investigation import investigate
from footcal_cli.core.diagnosis.library import Library, library
from footcal_cli.core.diagnosis.nested import level_of_fewer
from footcal_cli.core.diagnosis.rules import Rules
from footcal_cli.core.diagnosis.signals import describe
from footcal_cli.core.effects import TABLE
from footcal_cli.core.effects.contract import Effect
from footcal_cli.core.inference.case import every, residual, rows_of
from footcal_cli.core.inference.grams import whitened_grams
from footcal_cli.core.inference.ideal import balanced
from footcal_cli.core.inference.problem import Problem, Signature
from footcal_cli.core.inference.signatures import library_columns
from footcal_cli.core.inference.whitening import Noise, RowWhitener
from footcal_cli.core.parameters import FloatArray
from tests.core.test_diagnosis_bridge import ROBOT, walk_case

BLOCKS, ROWS = 12, 60


def problem_of(
    residual_: FloatArray, columns: FloatArray, signatures: tuple[Signature, ...]
) -> Problem:
    """One output in blocks of a series, an offset as calibration."""
    m = BLOCKS * ROWS
    block = np.repeat(np.arange(BLOCKS), ROWS)
    return Problem(
        residual=residual_, calibration=np.ones((m, 1)),
        columns=columns, signatures=signatures, block=block, output=np.zeros(m, dtype=np.int64),
        sequence=block, outputs=("f",), units=("N",), noise=np.ones(m), tolerance=np.ones(1),
        rate_hz=20.0,
    )  # fmt: skip


def library_of(problem: Problem) -> Library:
    grams, _ = whitened_grams(problem, np.empty((problem.residual.size, 0)))
    none = np.zeros(len(problem.signatures))
    return library(problem, grams, np.ones_like(none), none, Rules())


def test_offsets_are_compared_whatever_their_axes_and_impossible_copies_left_out() -> None:
    rng = np.random.default_rng(0)
    x, y, other = rng.normal(size=(3, BLOCKS * ROWS))
    turned = np.stack([x + y, x - y], axis=1) / np.sqrt(2.0)
    columns = np.column_stack([x, y, turned, -x - 0.5 * y, other])
    signatures = (
        Signature("a", "ax", "robot", "m"), Signature("a", "ay", "robot", "m"),
        Signature("b", "bu", "robot", "m"), Signature("b", "bv", "robot", "m"),
        # what would have to be negative to copy the offset
        Signature("late", "late", "robot", "s", lower=0.0),
        Signature("c", "c", "robot", "-"),
    )  # fmt: skip
    lib = library_of(problem_of(rng.normal(size=BLOCKS * ROWS), columns, signatures))
    found = {s.effect: cos for s, _, cos in aliases(lib, signatures[0], {"ax": 1.0, "ay": 0.5})}
    assert found["b"] == pytest.approx(1.0, abs=1e-6)
    assert "late" not in found
    assert found["c"] < 0.2
    back = {s.effect for s, _, _ in aliases(lib, signatures[0], {"ax": -1.0, "ay": -0.5})}
    assert "late" in back


def test_aliases_do_not_depend_on_the_residual_or_on_rounding() -> None:
    rng = np.random.default_rng(1)
    x = rng.normal(size=BLOCKS * ROWS)
    near = x + 0.2 * rng.normal(size=x.size)
    signatures = (Signature("a", "a", "robot", "s"), Signature("b", "b", "robot", "s"))
    noise = rng.normal(size=x.size)
    cos = []
    for shake in (0.0, 1e-13):
        columns = np.column_stack([x, near]) * (1.0 + shake)
        lib = library_of(problem_of(noise, columns, signatures))
        cos.append(aliases(lib, signatures[0], {"a": 1.0})[0][2])
    assert cos[0] == pytest.approx(cos[1], rel=1e-9)
    assert cos[0] == pytest.approx(1.0 / np.sqrt(1.04), abs=0.01)


def test_aliases_of_a_cause_that_the_linear_test_could_not_see() -> None:
    rng = np.random.default_rng(4)
    x = rng.normal(size=BLOCKS * ROWS)
    signatures = (Signature("a", "a", "robot", "N"), Signature("b", "b", "robot", "N"))
    problem = problem_of(x, np.column_stack([x, 2.0 * x]), signatures)
    grams, _ = whitened_grams(problem, np.empty((x.size, 0)))
    lib = library(problem, grams, np.array([0.0, 1.0]), np.zeros(2), Rules())
    assert not lib.testable[0]
    ((found, size, cos),) = aliases(lib, signatures[0], {"a": 1.0})
    assert found.effect == "b"
    assert size == pytest.approx(0.5)
    assert cos == pytest.approx(1.0)
    assert aliases(lib, Signature("a", "a", "elsewhere", "N"), {"a": 1.0}) == []


def test_a_low_pass_may_be_steeper_than_the_tables() -> None:
    """A Butterworth of a few milliseconds moves a walk as a delay does, not as a first-order lag.

    ``1/(1 + s + s²/2) = 1 − s + s²/2 + 0 s³``, the delay's series to the second order.
    """
    s = 1j * 2.0 * np.pi * 10.0 * 0.005
    steep = 1.0 / (1.0 + s + s**2 / 2.0)
    assert abs(steep - np.exp(-s)) < 0.2 * abs(steep - 1.0 / (1.0 + s))
    same = Rules().same
    assert never_distinguished("delay", {"lag": 0.97, "clock_drift": 0.96}, same) == {"lag"}
    assert never_distinguished("lag", {"delay": 0.97, "sensor_lag": 0.96}, same) == {"sensor_lag"}
    assert never_distinguished("lag", {"delay": 0.995}, same) == {"delay"}
    assert never_distinguished("nonlinearity", {"hinge": 0.97, "saturation": 0.995}, same) == {
        "saturation"
    }


def test_knees_are_one_curve_for_loads_of_one_sign() -> None:
    """With x > 0: ``x − s·(x − clip(x, ±L)) = x − s·max(x − L, 0)``, a hinge of −s."""
    alike, same = {"dead_zone": 0.97, "saturation": 0.97, "nonlinearity": 0.97}, Rules().same
    assert never_distinguished("hinge", alike, same) == {"dead_zone", "saturation"}
    log = walk_case(3, None, duration_s=12.0).logs[0]
    load = np.abs(log.readings) / np.abs(log.readings).max() * 10.0
    shown = [
        Chain((Link(TABLE[name], {"all": ROBOT.channels}),)).apply(log.with_readings(load), values)
        for name, values in (
            ("saturation", {"all.saturation": 0.7, "all.saturation_limit": 6.0}),
            ("hinge", {"all.hinge": -0.7, "all.hinge_load": 6.0}),
        )
    ]
    np.testing.assert_allclose(shown[0][0].readings, shown[1][0].readings, rtol=1e-12)


def test_rows_are_whitened_within_their_sequence_however_long_the_log() -> None:
    rng = np.random.default_rng(6)
    sequence = np.repeat(np.arange(50), rng.integers(2, 130, 50))
    output, columns = sequence % 2, rng.normal(size=(sequence.size, 3))
    a = np.array([[0.5, -0.2, 0.1], [0.4, 0.0, 0.0]])
    whitener = RowWhitener(a, np.array([1.0, 2.0]), output, sequence)
    order = np.array([3, 1])
    expected = [
        lfilter([1.0, *-a[o]], [1.0], columns[sequence == s], axis=0)[order[o] :] / (1.0 + o)
        for s, o in enumerate(np.arange(50) % 2)
    ]
    np.testing.assert_allclose(whitener(columns), np.concatenate(expected), atol=1e-13)
    assert sequence.size > 2048


@pytest.mark.parametrize("tracked", [True, False])
def test_a_fit_sees_the_same_whether_errors_are_counted_or_not(tracked: bool) -> None:
    case = walk_case(7, None, duration_s=60.0)
    rows = rows_of(case)
    problem = problem_from(case, rows, [TABLE["hysteresis"]], describe)
    if not tracked:  # free in every block instead
        problem = replace(problem, tracking=None)
    nothing = np.empty((problem.residual.size, 0))
    counted, fitted = (whitened_grams(problem, nothing, counted=c)[0] for c in (True, False))
    every = np.arange(counted.inner.size)
    np.testing.assert_array_equal(fitted.inner.among(every), counted.inner.among(every))
    np.testing.assert_array_equal(fitted.candidates, counted.candidates)
    assert not any(products.size for products in fitted.by_output)


def test_in_noise_of_its_own_a_worse_model_fits_as_well() -> None:
    rng = np.random.default_rng(2)
    noise = lfilter([1.0], [1.0, -0.6], rng.normal(size=BLOCKS * ROWS))
    wrong = noise + 2.0 * rng.normal(size=noise.size)
    none: tuple[Signature, ...] = ()
    good, bad = (problem_of(r, np.empty((noise.size, 0)), none) for r in (noise, wrong))

    def left(problem: Problem, law: Noise | None = None) -> float:
        inner = whitened_grams(problem, np.empty((noise.size, 0)), law)[0].inner
        return float(inner.squares(np.array([inner.last])).sum())

    own = [left(p) for p in (good, bad)]
    assert own[1] == pytest.approx(own[0], rel=0.02)
    levels = [p.law.level for p in (good, bad)]
    assert levels[0] < levels[1]
    shared = good.law
    judged = [left(p, shared) for p in (good, bad)]
    assert judged[1] > 3.0 * judged[0]


@pytest.mark.parametrize("effect", ["nonlinearity", "hysteresis", "delay", "com_offset"])
def test_only_judged_rows_are_balanced_and_nothing_changes(effect: str) -> None:
    case = walk_case(3, None, duration_s=12.0)
    rows = rows_of(case)
    row = TABLE[effect]
    owner = "robot" if effect in ("delay", "com_offset") else "left_fl"
    chain = case.chain.with_link(Link(row, {owner: (owner,)}))
    values = {**case.values, f"{owner}.{row.size.name}": 0.5 * row.size.prior_sd}
    found = residual(case, rows, values, chain)
    (log,) = case.logs
    error = case.experiment.balance(chain.remove(log, values)[0]).error
    assert found == pytest.approx(error[rows.row, rows.column] / rows.noise, abs=1e-9)
    assert len(case.judged[0]) == len(every(log, case.stride))


def test_readings_without_noise_are_the_same_on_the_judged_rows_alone() -> None:
    case = walk_case(3, None, duration_s=12.0)
    row = TABLE["nonlinearity"]
    chain = case.chain.with_link(Link(row, {"left_fl": ("left_fl",)}))
    values = {**case.values, f"left_fl.{row.size.name}": 0.5 * row.size.prior_sd}
    whole = balanced(case, values, chain)
    few = balanced(case, values, chain, judged=True)
    assert few.stride == 1 < case.stride
    assert few.logs[0].readings == pytest.approx(whole.judged[0].readings, rel=1e-9)
    lag = TABLE["lag"]
    remembering = chain.with_link(Link(lag, {"left_fl": ("left_fl",)}))
    values[f"left_fl.{lag.size.name}"] = 0.01
    all_rows = balanced(case, values, remembering, judged=True)
    assert len(all_rows.logs[0]) == len(case.logs[0])


def test_what_remembers_a_load_does_not_remember_the_noise_of_the_swing() -> None:
    """A row before lift-off reads what the swing's first row does, which is that one's residual."""
    case = walk_case(3, None, duration_s=24.0)
    (ideal,), (log,) = balanced(case, case.values).logs, case.logs
    clean, noisy = (case.chain.truth(one, case.values, None) for one in (ideal, log))
    valid = case.experiment.balance(noisy).valid[:, 3:]
    row, cell = np.nonzero(np.diff(valid.astype(int), axis=0) == 1)
    apart = np.diff(log.time_s)[row] < 0.02
    row, cell = row[apart], cell[apart]
    assert row.size > 20
    swing, before, cleaned = (
        noisy.readings[row + 1, cell], noisy.readings[row, cell], clean.readings[row, cell]
    )  # fmt: skip
    assert swing @ before > 0.5 * (swing @ swing)
    # what the balance of all cells says of that row is left
    assert abs(swing @ cleaned) < 0.25 * (swing @ swing)


def test_a_delay_is_compared_as_it_acts_at_its_own_size() -> None:
    """Of columns for each change of a size the one nearest to the fitted size speaks for it."""
    rng = np.random.default_rng(5)
    far = TABLE["delay"].size.far
    near, *others = rng.normal(size=(1 + len(far), BLOCKS * ROWS))
    columns = np.column_stack([near, *others, near])
    signatures = tuple(Signature("delay", "delay", "robot", "s") for _ in range(1 + len(far)))
    lib = library_of(problem_of(rng.normal(size=near.size), columns, (*signatures, _LAG)))
    ((found, size, cos),) = aliases(lib, signatures[0], {"delay": 0.01})
    assert found.effect == "lag"
    assert [size, cos] == pytest.approx([0.01, 1.0])
    assert aliases(lib, signatures[0], {"delay": far[-1]})[0][2] < 0.5
    # and the other way round: a lag copies the delay at the size at which that acts like it
    ((found, size, cos),) = aliases(lib, _LAG, {"lag": 0.01})
    assert found.effect == "delay"
    assert [size, cos] == pytest.approx([0.01, 1.0])


_LAG = Signature("lag", "lag", "robot", "s")


def test_a_hanging_sole_comes_on_over_the_transition() -> None:
    case = walk_case(4, None, duration_s=12.0)
    (log,) = case.logs
    plate = TABLE["hanging_plate"]
    chain = case.chain.with_link(Link(plate, {"left": ("left",)}))
    values = {**case.values, "left.plate_weight": 2.0}
    soft = log.with_known(airborne=airborne(log.known["contact"]))
    step = chain.remove(soft, values)[0].readings - case.chain.remove(soft, case.values)[0].readings
    left = [c.startswith("left") for c in ROBOT.channels]
    share = soft.known["airborne"][:, 0]
    assert step[:, left] == pytest.approx(np.repeat(0.5 * share[:, None], sum(left), axis=1))
    assert np.any((share > 0.1) & (share < 0.9))


def test_a_walk_asks_of_each_cell_that_another_may_hear() -> None:
    """In the sum of all cells whichever of them is heard is a gain: the moments tell them apart."""
    case = every_shape_of(TABLE["crosstalk"])
    assert {dict(s.shape)["crosstalk_from"] for s in case if s.where == "all cells"} == {0, 1, 2, 3}


def every_shape_of(effect: Effect) -> tuple[Signature, ...]:
    case = walk_case(0, duration_s=20.0)
    return library_columns(case, rows_of(case), [effect]).signatures


def test_a_name_is_asked_for_as_much_evidence_per_block_with_a_block_less() -> None:
    """Ten equal blocks at the level leave nine at 0.01^(9/10)."""
    assert level_of_fewer(0.01, 9, 10) == pytest.approx(0.015849, abs=1e-6)
    assert level_of_fewer(0.01, 3, 10) == pytest.approx(1.0)


def test_an_effect_that_one_cell_has_already_is_sought_in_its_group_and_in_the_others() -> None:
    """A calibration with hysteresis of one cell: a foot may have more of it, by finite differences.

    The reach of the foot's is that of its signature; the calibrated one stays as it is.
    """
    case, effect = walk_case(5, None, duration_s=12.0), TABLE["hysteresis"]
    chain = case.chain.with_link(Link(effect, {"left_fl": ("left_fl",)}))
    given = {"left_fl.hysteresis_width": 0.4, "left_fl.hysteresis_reach": 3.0}
    case = case.extended(chain, {**case.values, **given})
    rows = rows_of(case)
    found = library_columns(case, rows, [effect])
    places = {s.where for s in found.signatures}
    assert "left_fl" not in places
    assert {"all cells", "left foot", "left_fr"} <= places
    at = next(i for i, s in enumerate(found.signatures) if s.where == "left foot")
    (signature, size) = found.signatures[at], 0.01
    more = case.chain.with_link(Link(effect, dict(signature.owners)))
    reach = {f"left.{name}": value for name, value in signature.shape}
    none, some = (
        residual(case, rows, {**case.values, **reach, "left.hysteresis_width": w}, more)
        for w in (0.0, size)
    )
    expected = (none - some) / size
    np.testing.assert_allclose(
        found.columns[at], expected, atol=0.02 * float(np.abs(expected).max())
    )


@pytest.mark.parametrize(
    ("table", "duration_s"),
    [
        ({k: TABLE[k] for k in ("nonlinearity", "nonlinearity_cubic", "hinge", "dead_zone")}, 30.0),
        pytest.param(TABLE, 60.0, marks=pytest.mark.slow),
    ],
    ids=["curves", "all"],
)
def test_a_dead_zone_that_is_undone_is_not_blamed_for_the_noise_of_small_loads(
    table: dict[str, Effect], duration_s: float
) -> None:
    cell = ROBOT.channels[0]
    sizes = {f"{cell}.dead_zone": 0.4, f"{cell}.dead_zone_width": 5.0}
    case = walk_case(3, ("dead_zone", {cell: (cell,)}, sizes), duration_s=duration_s)
    log, rng = case.logs[0], np.random.default_rng(3)
    noise = lfilter([np.sqrt(1.0 - 0.95**2)], [1.0, -0.95], rng.normal(size=log.readings.shape), 0)
    scale = np.array([case.values[f"{c}.scale"] for c in ROBOT.channels])
    loud = replace(log, readings=log.readings + 0.15 * noise / scale)
    found = investigate(replace(case, logs=(loud,)), table, describe)
    (named,) = found.found
    assert found.verdict in (Verdict.NAMED, Verdict.AMBIGUOUS)
    assert named.owner == cell
    said = {named.cause.signature.effect, *(r.effect for r in named.cause.rivals)}
    assert "dead_zone" in said
    # the error of the swings is larger than before: small loads are as uncertain as they were
    assert any(gain.after > gain.before for gain in found.gains)
