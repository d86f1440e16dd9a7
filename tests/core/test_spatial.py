"""Rotations and wrenches against matrix exponentials, inverses and finite differences."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import expm
from scipy.spatial.transform import Rotation

from footcal_cli.core import spatial
from footcal_cli.core.parameters import FloatArray

VECTORS: FloatArray = np.concatenate(
    [
        np.random.default_rng(1).normal(size=(20, 3)),
        1e-9 * np.ones((1, 3)),
        np.zeros((1, 3)),
        np.array([[0.0, 3e-5, 0.0], [0.0, 0.0, 1.2e-4]]),
    ]
)


def test_skew_is_the_cross_product() -> None:
    a = np.random.default_rng(2).normal(size=VECTORS.shape)
    np.testing.assert_allclose(
        np.einsum("nij,nj->ni", spatial.skew(VECTORS), a), np.cross(VECTORS, a), atol=1e-14
    )
    np.testing.assert_allclose(spatial.unskew(spatial.skew(VECTORS)), VECTORS)


def test_cayley_is_the_papers_formula_and_a_rotation() -> None:
    rotation = spatial.cayley(VECTORS)
    for q, matrix in zip(VECTORS, rotation, strict=True):
        s = spatial.skew(q)
        np.testing.assert_allclose(matrix, (np.eye(3) - s) @ np.linalg.inv(np.eye(3) + s))
    np.testing.assert_allclose(np.linalg.det(rotation), 1.0)
    # a turn by 2 atan |q| about -q
    length = np.linalg.norm(VECTORS, axis=1, keepdims=True)
    turn = Rotation.from_rotvec(-2.0 * np.arctan(length) / np.maximum(length, 1e-300) * VECTORS)
    np.testing.assert_allclose(rotation, turn.as_matrix(), atol=1e-12)


def test_rotation_exp_matches_the_matrix_exponential() -> None:
    for v, matrix in zip(VECTORS, spatial.rotation_exp(VECTORS), strict=True):
        np.testing.assert_allclose(matrix, expm(spatial.skew(v)), atol=1e-13)


@pytest.mark.parametrize("angle", [0.0, 1e-10, 1e-5, 0.3, 2.0, 3.0, np.pi - 1e-6, np.pi])
def test_rotation_log_inverts_exp_up_to_a_half_turn(angle: float) -> None:
    axes = np.random.default_rng(3).normal(size=(50, 3))
    axes /= np.linalg.norm(axes, axis=1, keepdims=True)
    rotation = spatial.rotation_exp(angle * axes)
    again = spatial.rotation_exp(spatial.rotation_log(rotation))
    np.testing.assert_allclose(again, rotation, atol=1e-9)
    if angle < 3.0:
        np.testing.assert_allclose(spatial.rotation_log(rotation), angle * axes, atol=1e-10)


def test_left_jacobian_matches_finite_differences() -> None:
    step = 1e-6
    jacobian = spatial.left_jacobian(VECTORS)
    inverse = np.swapaxes(spatial.rotation_exp(VECTORS), -1, -2)
    for i, e in enumerate(np.eye(3)):
        moved = spatial.rotation_exp(VECTORS + step * e) @ inverse
        np.testing.assert_allclose(spatial.rotation_log(moved) / step, jacobian[:, :, i], atol=5e-6)


def test_tangent_basis_is_orthonormal_and_natural_on_axes() -> None:
    unit = VECTORS[:20] / np.linalg.norm(VECTORS[:20], axis=1, keepdims=True)
    basis = spatial.tangent_basis(unit)
    np.testing.assert_allclose(np.einsum("ni,nij->nj", unit, basis), 0.0, atol=1e-14)
    np.testing.assert_allclose(np.einsum("nij,nik->njk", basis, basis) - np.eye(2), 0.0, atol=1e-14)
    np.testing.assert_allclose(np.abs(spatial.tangent_basis(np.eye(3)[0])), np.eye(3)[:, 1:])


def test_wrench_transform_keeps_virtual_power() -> None:
    rng = np.random.default_rng(4)
    rot_ab = Rotation.random(rng=4).as_matrix()
    pos_a, force_b, torque_b = rng.normal(size=(3, 3))
    twist_linear_a, twist_angular_a = rng.normal(size=(2, 3))
    moved = spatial.wrench_transform(rot_ab, pos_a) @ np.r_[force_b, torque_b]
    at_b = twist_linear_a + np.cross(twist_angular_a, pos_a)
    power_b = force_b @ (rot_ab.T @ at_b) + torque_b @ (rot_ab.T @ twist_angular_a)
    assert moved[:3] @ twist_linear_a + moved[3:] @ twist_angular_a == pytest.approx(power_b)


@pytest.mark.parametrize("roll", [0.0, 0.4])
def test_a_link_whose_x_axis_points_down_has_the_heading_of_its_robot(roll: float) -> None:
    """A foot that leans by degrees turns left by 2 rad; its link's axes are those of a leg."""
    yaw = np.linspace(-0.5, 1.5, 200)
    lean = np.random.default_rng(4).normal(0.0, 0.03, (200, 2))
    pitch = 0.3 * np.sin(np.linspace(0.0, 20.0, 200)) + lean[:, 1]
    foot = Rotation.from_euler("ZYX", np.stack([yaw, pitch, lean[:, 0]], axis=1))
    link = foot * Rotation.from_euler("YX", [np.pi / 2.0, roll])
    assert np.abs(link.as_matrix()[:, 2, 0]).min() > 0.9, "x points down"
    np.testing.assert_allclose(spatial.headings(foot.as_matrix()), yaw, atol=1e-9)
    off = spatial.headings(link.as_matrix()) - yaw
    assert abs(off.mean() + roll) < 0.03, "what is left of a turn about the leg is constant"
    assert off.std() < 0.08
