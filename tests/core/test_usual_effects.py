"""What every walk has: the forces and moments that Newton and Euler ask, taken back exactly."""

from __future__ import annotations

import numpy as np
import pytest

from footcal_cli.core.chain import Chain, Link
from footcal_cli.core.contact import cycle_phase
from footcal_cli.core.effects.contract import Effect, Scope, units_of
from footcal_cli.core.effects.usual import (
    CHANGE_OF_FOOT,
    FOOT_INERTIA,
    GAIT_MOMENT,
    LEG_MASS,
    LEG_SWING,
    LIMB_SWING,
)
from footcal_cli.core.experiments import stand, walk
from footcal_cli.core.log import Log
from tests.core.ankle_walks import CHANNELS, ankle_walk

OFFSETS = dict.fromkeys(CHANNELS, 0.0)


@pytest.fixture(scope="module")
def log() -> Log:
    """A walk on six-axis ankles that came without its angular momentum."""
    whole = ankle_walk(3, 20.0, OFFSETS, {})[0].log
    phase = cycle_phase(whole.known["contact"])
    return whole.with_known(angmom_missing=np.ones(len(whole)), gait_phase=phase)


def alone(effect: Effect, log: Log, sizes: dict[str, float]) -> tuple[Chain, dict[str, float]]:
    """A chain with this effect in every unit, and values of its sizes."""
    owners = units_of(effect.scope, log.channels)
    chain = Chain((Link(effect, {owner: (owner,) for owner in owners}),))
    return chain, {f"{o}.{p.name}": sizes.get(p.name, 0.0) for o in owners for p in effect.sizes}


@pytest.mark.parametrize(
    "effect", [FOOT_INERTIA, LEG_SWING, GAIT_MOMENT, LIMB_SWING, LEG_MASS, CHANGE_OF_FOOT]
)
def test_what_is_applied_is_taken_back(effect: Effect, log: Log) -> None:
    chain, values = alone(effect, log, {p.name: 0.1 * p.prior_sd for p in effect.sizes})
    shown = chain.apply(log, values)[0]
    moved = [shown.readings - log.readings]
    moved += [shown.known[k] - log.known[k] for k in ("angmom_rate_nm", "com_acc_mps2")]
    assert max(np.abs(change).max() for change in moved) > 1e-6
    back = chain.remove(shown, values)[0]
    # a share of the mass moves the CoM that it is a share of: the second order stays
    least = 1e-4 if effect is LEG_MASS else 1e-9
    np.testing.assert_allclose(back.readings, log.readings, atol=least)
    for name in ("angmom_rate_nm", "com_acc_mps2", "com_m"):
        np.testing.assert_allclose(back.known[name], log.known[name], atol=least)


def test_a_foot_below_its_transducer_pulls_back_with_its_mass(log: Log) -> None:
    """``f = −m Rᵀ (a + g e_z)``, its torque with the first moment q as lever."""
    mass, moment = 1.3, np.array([0.02, -0.01, -0.05])
    sizes = {"mass_below": mass} | dict(zip(("moment_below_x", "moment_below_y", "moment_below_z"),
                                            moment, strict=True))  # fmt: skip
    chain, values = alone(FOOT_INERTIA, log, sizes)
    change = (chain.apply(log, values)[0].readings - log.readings).reshape(len(log), -1, 6)
    up = np.array([0.0, 0.0, 1.0]) * log.known["gravity_mps2"][:, None, None]
    rot = log.known["foot_rot_wt"]
    specific = np.einsum("nkji,nkj->nki", rot, log.known["foot_acc_mps2"] + up)
    np.testing.assert_allclose(change[..., :3], -mass * specific, atol=1e-9)
    np.testing.assert_allclose(change[..., 3:], -np.cross(moment, specific), atol=1e-9)


def test_a_point_mass_at_each_foot_is_what_swings(log: Log) -> None:
    """``L̇ = Σ m (p − c) × (p̈ − c̈)`` of feet on the floor, c at its height."""
    mass = 2.5
    chain, values = alone(LEG_SWING, log, {"leg_swing": mass})
    change = chain.apply(log, values)[0].known["angmom_rate_nm"] - log.known["angmom_rate_nm"]
    known, expected = log.known, np.zeros((len(log), 2))
    for foot in range(2):
        place = known["foot_pos_m"][:, foot].copy()
        place[:, 2] = 0.0
        acc = known["foot_acc_mps2"][:, foot] - known["com_acc_mps2"]
        expected -= mass * np.cross(place - known["com_m"], acc)[:, :2]
    np.testing.assert_allclose(change, expected, atol=1e-9)


def test_a_moment_of_the_gait_has_no_mean_over_a_cycle(log: Log) -> None:
    chain, values = alone(GAIT_MOMENT, log, {"gait_moment_x_cos2": 3.0, "gait_moment_y_sin1": 2.0})
    change = chain.apply(log, values)[0].known["angmom_rate_nm"] - log.known["angmom_rate_nm"]
    whole = np.isfinite(cycle_phase(log.known["contact"]))
    assert np.abs(change[whole]).max() > 1.5
    assert np.all(change[~whole] == 0.0)
    np.testing.assert_allclose(change[whole].mean(axis=0), 0.0, atol=0.05)


def test_a_leg_is_a_foot_where_its_transducer_is_in_the_foot(log: Log) -> None:
    assert units_of(Scope.FOOT, log.channels) == walk.feet_of(log)
    assert units_of(Scope.FOOT, ("left_a", "left_b", "right_a")) == ("left", "right")


def test_a_model_s_com_is_off_by_a_share_of_its_height(log: Log) -> None:
    """Half a millimetre on a robot whose CoM is 25 cm high, stands alike."""
    height = float(np.median(log.known["com_m"][:, 2]))
    assert list(walk.OF_A_MODEL.usual_on([log]).values()) == pytest.approx([0.002 * height] * 2)
    swung = {item.effect.name for item in walk.ON_SIX_AXIS.imperfections}
    still = {item.effect.name for item in stand.ON_SIX_AXIS.imperfections}
    assert swung - still == {
        "change_of_foot", "leg_mass", "leg_swing", "gait_moment", "foot_inertia"
    }  # fmt: skip
