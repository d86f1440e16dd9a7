"""The menu of experiments: what is predicted, against closed forms and against diagnoses."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from footcal_cli.core.chain import Chain
from footcal_cli.core.diagnosis.menu import LIKE, advice, menu_for, repeats_for
from footcal_cli.core.diagnosis.plans import PLANS, Plan
from footcal_cli.core.diagnosis.rehearsal import Contender, Rehearsal, rehearsed
from footcal_cli.core.diagnosis.rig import Rig
from footcal_cli.core.effects import TABLE
from footcal_cli.core.experiments import stand
from footcal_cli.core.inference.problem import Signature
from footcal_cli.core.log import Log
from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.simulation.biped_logs import (
    Course,
    StandPlan,
    Streams,
    biped_logs,
    standing_motion,
)
from footcal_cli.core.simulation.robots import Biped
from footcal_cli.errors import UsageError
from footcal_cli.sheets.diagnosis.experiment import experiment_record

BENCH = Rig(noise_n=0.05, full_load_n=30.0, kinds=("weights",))
WALKER = Rig(noise={"fz": 0.2, "mx": 0.02, "my": 0.02}, independent_hz=10.0)


def plan_of(name: str) -> Plan:
    return next(plan for plan in PLANS if plan.id == name)


def contender(name: str, **values: float) -> Contender:
    size = next(iter(values), TABLE[name].size.name)
    shapes = {p.name: p.neutral for p in TABLE[name].shapes}
    usual = {size: TABLE[name].size.neutral + TABLE[name].size.prior_sd}
    return Contender(Signature(name, size, "all cells", ""), {**shapes, **usual, **values})


def test_every_plan_is_balanced_by_itself() -> None:
    """Nothing wrong, nothing left: planned loads obey the physics the experiment is judged by."""
    for plan in PLANS:
        for log in plan.make(Rig()):
            balance = plan.experiment.balance(log)
            assert np.abs(balance.error[balance.valid]).max() < 1e-6, plan.id


def test_ids_are_unique_and_told_in_the_menu() -> None:
    import footcal_cli.core.diagnosis.menu as menu

    ids = [plan.id for plan in PLANS]
    assert len(set(ids)) == len(ids)
    assert menu.__doc__ is not None
    assert all(f"``{name}``" in menu.__doc__ for name in ids)


def test_a_quadratic_beside_scale_and_bias_by_hand() -> None:
    """What is left of ``q F²`` is its residual on 1 and F."""
    rehearsal = rehearsed(plan_of("up_down"), BENCH)
    curve = contender("nonlinearity", quadratic=1e-3)
    load = plan_of("up_down").make(BENCH)[0].readings[:, 0]
    basis = np.column_stack([np.ones_like(load), load])
    left = 1e-3 * load**2
    left -= basis @ np.linalg.lstsq(basis, left, rcond=None)[0]
    shown = rehearsal.shown(TABLE["nonlinearity"], curve.signature, curve.values)
    np.testing.assert_allclose(shown, left / BENCH.noise_n, atol=1e-6)
    # four cells that carry it are weighed one after the other: twice the separation
    four = replace(curve.signature, owners=(("all", ("a", "b", "c", "d")),))
    of_four = rehearsal.shown(TABLE["nonlinearity"], four, curve.values)
    np.testing.assert_allclose(of_four, 2.0 * shown, atol=1e-6)


def test_the_menu_separates_what_it_can_and_says_what_it_cannot() -> None:
    curve_or_creep = menu_for([contender("nonlinearity"), contender("creep")], TABLE, BENCH)
    assert curve_or_creep.best is not None
    assert curve_or_creep.best.left == 0.0
    assert curve_or_creep.best.separation > 3
    # delays of the body's telemetry are not seen on a bench
    none = menu_for([contender("delay"), contender("lag")], TABLE, BENCH)
    assert none.prospects == ()


def test_dead_zone_and_hinge_are_one_until_the_cell_is_pulled() -> None:
    """``min(F, 4)`` is a scale change plus ``max(F − 4, 0)``: the same curve while F ≥ 0."""
    rivals = [
        contender("dead_zone", dead_zone=0.1, dead_zone_width=4.0),
        contender("hinge", hinge=0.1, hinge_load=4.0),
    ]
    menu = menu_for(rivals, TABLE, BENCH)
    assert [p.plan.id for p in menu.prospects] == ["push_pull"]
    assert menu.prospects[0].cosine < 0.9


@pytest.mark.parametrize(
    ("first", "second", "expected"),
    [
        (
            contender("imu_tilt", imu_pitch=0.0175),
            contender("floor_slope", floor_pitch=0.0175),
            {"walk_turning", "turn_and_bounce"},
        ),
        (
            contender("imu_tilt", imu_pitch=0.0175),
            contender("com_offset", com_correction_x=0.004),
            {"bounce", "turn_and_bounce"},
        ),
        (
            contender("com_offset", com_correction_x=0.004),
            contender("cell_position", cell_correction_x=0.004),
            {"turn_and_bounce", "stand_turned", "holes"},
        ),
        (contender("leg_weight"), contender("robot_weight"), {"weigh_robot"}),
    ],
)
def test_aliases_of_a_robot_find_their_experiment(
    first: Contender, second: Contender, expected: set[str]
) -> None:
    menu = menu_for([first, second], TABLE, WALKER)
    assert menu.prospects
    assert menu.prospects[0].left == 0.0
    assert menu.prospects[0].plan.id in expected


@pytest.mark.slow
@pytest.mark.parametrize("plan", ["weigh_standing", "weigh_walking"])
@pytest.mark.parametrize("rival", ["load_bypass", "hinge"])
def test_a_scale_settles_a_wrong_mass_whatever_copies_it(rival: str, plan: str) -> None:
    menu = menu_for([contender("mass"), contender(rival)], TABLE, WALKER)
    weighed = next(p for p in menu.prospects if p.plan.id == plan)
    assert (weighed.left, weighed.cosine, weighed.minutes) == (0.0, 0.0, 5.0)


def test_toes_turned_out_and_in_tell_a_foot_from_the_body() -> None:
    """A shift of all cells in their feet is one of the CoM while both feet point ahead."""
    body = contender("com_offset", com_correction_x=0.003, com_correction_y=0.002)
    foot = contender("cell_position", cell_correction_x=0.003, cell_correction_y=0.002)
    ahead = rehearsed(plan_of("bounce"), WALKER).compared(body, foot, TABLE)
    turned = rehearsed(plan_of("turn_and_bounce"), WALKER).compared(body, foot, TABLE)
    assert ahead.cosine > 0.999
    assert turned.cosine < LIKE


def test_toes_turned_out_and_in_tell_them_while_standing_too() -> None:
    """With feet that point ahead no stance does: both are one shift of the CoP."""
    body = contender("com_offset", com_correction_x=0.003, com_correction_y=0.002)
    foot = contender("cell_position", cell_correction_x=0.003, cell_correction_y=0.002)
    turned = rehearsed(plan_of("stand_turned"), WALKER).compared(body, foot, TABLE)
    assert turned.cosine < LIKE
    ahead = replace(plan_of("stand_turned"), make=_standing_ahead)
    assert rehearsed(ahead, WALKER).compared(body, foot, TABLE).cosine > 0.999


def _standing_ahead(rig: Rig) -> tuple[Log, ...]:
    plan = StandPlan(stances=24, stance_s=4.0, sway_m=0.0, replaced=False)
    done = biped_logs(
        Course("stand", rig.biped, standing_motion(rig.biped, plan, 0), plan.duration_s),
        Chain(()), {}, seed=0, streams=Streams(cell_rate_hz=2.0), to_counts=False,
    )  # fmt: skip
    return (done.cells.truth,)


def test_noise_of_a_quiet_robot_is_not_that_of_a_moving_one() -> None:
    """Beside what standing showed, a motion's balance has ``m σ`` and ``m h σ`` of the IMU."""
    still = Rig(noise={"fz": 0.03, "my": 0.004}, moving_mps2=0.05)
    mass, height = still.biped.mass_kg, still.biped.com_height_m
    assert still.noise_of("fz", "N", "walk") == pytest.approx(np.hypot(0.03, mass * 0.05))
    assert still.noise_of("my", "Nm", "walk") == pytest.approx(
        np.hypot(0.004, mass * height * 0.05)
    )
    assert still.noise_of("fz", "N", "stand") == 0.03
    assert still.noise_of("left_fl", "N", "walk") == still.noise_n


def test_a_delay_is_told_from_a_low_pass_by_switching_the_low_pass_off() -> None:
    """No motion does it: a low-pass of high order is a delay up to its corner."""
    menu = menu_for([contender("delay", delay=0.002), contender("lag", lag=0.002)], TABLE, WALKER)
    assert [p.plan.id for p in menu.prospects] == ["walk_unsmoothed"]
    assert menu.prospects[0].cosine == 0.0
    assert experiment_record(menu).without == ("lag",)  # type: ignore[union-attr]
    # what stays there is as large as it would be anyway
    there = rehearsed(plan_of("walk_unsmoothed"), WALKER)
    delay, lag = contender("delay", delay=0.002), contender("lag", lag=0.002)
    assert np.abs(there.shown(TABLE["delay"], delay.signature, delay.values)).max() > 1.0
    assert not there.shown(TABLE["lag"], lag.signature, lag.values).any()
    # and other rivals are not asked to
    level = [contender("imu_tilt", imu_pitch=0.0175), contender("floor_slope", floor_pitch=0.0175)]
    assert "walk_unsmoothed" not in {p.plan.id for p in menu_for(level, TABLE, WALKER).prospects}
    assert advice([TABLE["delay"], TABLE["lag"]]).count("500 Hz") == 1


def test_a_hanging_refits_the_weight_of_the_leg() -> None:
    """A leg that is heavier than believed hangs without a trace: `hang-calib` weighs it."""
    hung = rehearsed(plan_of("hang"), Rig())
    heavy = contender("leg_weight")
    assert not hung.shown(TABLE["leg_weight"], heavy.signature, heavy.values).any()
    assert hung.compared(heavy, contender("robot_weight"), TABLE).cosine == 1.0


def test_what_would_make_the_robot_fall_is_not_proposed() -> None:
    tall = replace(WALKER, biped=replace(Biped(), com_height_m=3.0))
    with pytest.raises(UsageError, match="leaves the foot"):
        plan_of("walk_squatting").make(tall)
    menu = menu_for(
        [contender("imu_tilt", imu_pitch=0.0175), contender("com_offset", com_correction_x=0.004)],
        TABLE, tall,
    )  # fmt: skip
    assert menu.prospects
    assert "walk_squatting" not in {p.plan.id for p in menu.prospects}


def test_repeats_are_the_textbook_number() -> None:
    """``n = ((z_{.995} + z_{.8}) / d)²``: 12 runs at d = 1 (Cohen 1988); ten blocks at least."""
    assert repeats_for(1.0) == 12
    assert repeats_for(10.0) == 1
    assert repeats_for(10.0, blocks=1) == 10
    assert repeats_for(0.0) > 10**5


def test_work_of_another_kind_counts_double() -> None:
    """A walk asks about tilts and accelerations that a standing robot's balance does not know."""
    rivals = [contender("com_offset", com_correction_x=0.004),
              contender("cell_position", cell_correction_x=0.004)]  # fmt: skip
    standing_now = Rehearsal(stand.EXPERIMENT, _standing_ahead(WALKER), WALKER)
    menu = menu_for(rivals, TABLE, WALKER, standing_now)
    assert menu.best is not None
    assert menu.best.plan.id == "stand_turned"
    others = [p for p in menu.prospects if p.left == menu.best.left and p is not menu.best]
    assert all(2.0 * p.minutes >= menu.best.minutes for p in others)


@pytest.mark.parametrize("delay_s", [0.004, 0.02])
@pytest.mark.parametrize(("stop", "told"), [(1.5, True), (2.0, False), (4.0, False)])
def test_a_stop_must_be_as_quick_as_the_delay_to_tell_it_from_a_butterworth(
    delay_s: float, stop: float, told: bool
) -> None:
    """``1/(1 + s τ + (s τ)²/2)`` is ``exp(−s τ)`` but for the third order: only a motion that
    ends within one and a half delays has what they differ in. Why no motion is on the menu."""
    rate = 200.0 / delay_s
    time_s = np.arange(0.0, 60.0 * delay_s, 1.0 / rate)
    width = stop * delay_s
    brake = np.clip((time_s - 20.0 * delay_s) / width, 0.0, 1.0)
    fall = np.clip((time_s - 20.0 * delay_s) / (3.0 * width) + 1.0, 0.0, 1.0)
    acc = np.sin(np.pi * brake) ** 2 - np.sin(np.pi * fall) ** 2 / 3.0
    s = 2j * np.pi * np.fft.rfftfreq(2 * acc.size, 1.0 / rate)
    spectrum = np.fft.rfft(acc, 2 * acc.size)

    def left(response: NDArray[Any]) -> FloatArray:
        """What a filter adds, beside the cells' gain and bias."""
        added = np.fft.irfft(spectrum * (response - 1.0))[: acc.size]
        basis = np.column_stack([np.ones(acc.size), acc])
        return np.asarray(added - basis @ np.linalg.lstsq(basis, added, rcond=None)[0])

    late = left(np.exp(-s * delay_s))
    cosines = []
    for lag_s in delay_s * np.linspace(0.5, 1.5, 21):
        x = s * lag_s
        copy = left(1.0 / (1.0 + x + 0.5 * x**2))
        cosines.append(abs(copy @ late) / np.sqrt((copy @ copy) * (late @ late)))
    assert (max(cosines) < LIKE) == told
