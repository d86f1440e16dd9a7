import numpy as np
import pytest

from footcal_cli.core.centroidal import (
    dynamic_reference,
    points_in_world,
    pressure,
    static_reference,
)
from footcal_cli.core.parameters import FloatArray
from tests.core.walk_data import make_walk

G = 9.80665


def random_contacts(
    seed: int, n: int = 50, k: int = 6
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    points = rng.uniform(-0.2, 0.2, (n, k, 3))
    points[:, :, 2] = 0.0
    forces = rng.normal(0.0, 5.0, (n, k, 3))
    forces[:, :, 2] = rng.uniform(1.0, 20.0, (n, k))
    com = np.column_stack([rng.uniform(-0.05, 0.05, (n, 2)), rng.uniform(0.2, 0.3, n)])
    return forces, points, com


def motion_under(
    forces_n: FloatArray, points_m: FloatArray, com_m: FloatArray, mass_kg: float
) -> tuple[FloatArray, FloatArray]:
    """Acceleration of the CoM and rate of angular momentum about it: [NAO], eqs. (6)(7)."""
    acc = forces_n.sum(axis=1) / mass_kg - np.array([0.0, 0.0, G])
    return acc, np.cross(points_m - com_m[:, None], forces_n).sum(axis=1)


def test_newton_and_euler_give_back_the_cop_of_any_contact_forces() -> None:
    # (6)(7) turn forces into motion, (9)-(11) turn the motion back into Fz and CoP: exact
    forces, points, com = random_contacts(1)
    acc, rate = motion_under(forces, points, com, 5.3)
    reference = dynamic_reference(com, acc, rate[:, :2], 5.3, G)
    centre = pressure(forces[:, :, 2], points[:, :, :2])
    np.testing.assert_allclose(reference.fz_n, centre.fz_n, rtol=1e-12)
    np.testing.assert_allclose(reference.cop_m, centre.cop_m, atol=1e-12)


def test_without_the_angular_momentum_the_cop_is_off_by_its_share() -> None:
    forces, points, com = random_contacts(2)
    acc, rate = motion_under(forces, points, com, 5.3)
    full = dynamic_reference(com, acc, rate[:, :2], 5.3, G)
    without = dynamic_reference(com, acc, np.zeros((50, 2)), 5.3, G)
    expected = np.stack([rate[:, 1], -rate[:, 0]], axis=1) / full.fz_n[:, None]
    np.testing.assert_allclose(without.cop_m - full.cop_m, expected, atol=1e-12)


def test_standing_still_the_cop_lies_below_the_com_and_carries_the_weight() -> None:
    com = np.array([[0.02, -0.01, 0.25]])
    reference = dynamic_reference(com, np.zeros((1, 3)), np.zeros((1, 2)), 5.0, G)
    still = static_reference(com, 5.0, G)
    np.testing.assert_allclose(reference.cop_m, com[:, :2], atol=1e-15)
    np.testing.assert_allclose(reference.fz_n, 5.0 * G)
    np.testing.assert_allclose(still.cop_m, reference.cop_m, atol=1e-15)
    np.testing.assert_allclose(still.fz_n, reference.fz_n)


def test_no_cop_is_invented_where_the_force_is_too_small() -> None:
    forces = np.array([[1.0, 1.0], [4.0, 4.0]])
    points = np.zeros((2, 2, 2))
    centre = pressure(forces, points, min_force_n=5.0)
    assert centre.valid.tolist() == [False, True]
    assert np.isnan(centre.cop_m[0]).all()


def test_in_free_fall_there_is_no_reference_cop() -> None:
    acc = np.array([[0.0, 0.0, -G]])
    reference = dynamic_reference(np.array([[0.0, 0.0, 0.3]]), acc, np.zeros((1, 2)), 5.0, G)
    assert np.isnan(reference.cop_m).all()


def test_points_turn_and_move_with_the_foot() -> None:
    corner = np.array([[0.07, 0.03]])
    there = points_in_world(np.array([[1.0, 2.0]]), np.array([np.pi / 2]), corner)
    np.testing.assert_allclose(there[0, 0], [1.0 - 0.03, 2.0 + 0.07], atol=1e-15)


@pytest.mark.parametrize("speed", [0.02, 0.1])
def test_a_walking_pendulum_balances_on_its_cells(speed: float) -> None:
    motion = make_walk(speed, 12.0, seed=3)
    reference = dynamic_reference(motion.com, motion.acc, motion.angmom_rate, motion.mass, G)
    centre = pressure(motion.force, motion.cells)
    middle = slice(100, -100)
    assert np.abs(reference.fz_n - centre.fz_n)[middle].max() < 1e-6
    assert np.abs(reference.cop_m - centre.cop_m)[middle].max() < 1e-6
