"""Long tables to frames, quaternions and angles to rotations, orientation names to directions."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from footcal_cli.core.hang.intake import gravity_of_orientation, legs_in_order
from footcal_cli.core.pose.intake import frames_of
from footcal_cli.core.spatial import rotation_of_quaternion, rotation_of_rpy


def test_frames_keep_the_order_of_legs_and_drop_what_is_not_whole() -> None:
    key = np.array([7, 7, 3, 3, 5, 9, 9, 9, 4, 4])
    leg = np.array(["b", "a", "a", "b", "a", "a", "b", "b", "a", "b"])
    value = np.arange(10.0)
    value[9] = np.nan
    frames = frames_of(key, leg, ("a", "b"), {"value": value})
    np.testing.assert_array_equal(frames.keys, [7, 3])
    np.testing.assert_array_equal(frames.columns["value"], [[1.0, 0.0], [2.0, 3.0]])
    assert (frames.incomplete, frames.broken) == (2, 1)


def test_several_readings_of_every_leg_in_a_pose_become_their_median() -> None:
    key = np.array([1, 1, 1, 1, 1, 1, 2, 2, 2])
    leg = np.array(["a", "b", "a", "b", "a", "b", "a", "b", "b"])
    value = np.array([1.0, 10.0, 2.0, np.nan, 90.0, 12.0, 5.0, 6.0, 7.0])
    frames = frames_of(key, leg, ("a", "b"), {"value": value})
    np.testing.assert_array_equal(frames.keys, [1])
    np.testing.assert_array_equal(frames.columns["value"], [[2.0, 11.0]])
    assert frames.incomplete == 1


def test_frames_ignore_other_legs_and_allow_named_gaps() -> None:
    key = np.array([1, 1, 1])
    leg = np.array(["a", "b", "tail"])
    gap = np.array([1.0, np.nan, 2.0])
    frames = frames_of(key, leg, ("a", "b"), {"contact": gap}, may_miss=("contact",))
    assert frames.columns["contact"].shape == (1, 2)
    assert frames.broken == 0


def test_rotations_agree_with_scipy() -> None:
    quaternion = np.random.default_rng(1).normal(size=(20, 4))
    np.testing.assert_allclose(
        rotation_of_quaternion(quaternion), Rotation.from_quat(quaternion).as_matrix(), atol=1e-12
    )
    rpy = [0.3, -0.7, 2.0]
    np.testing.assert_allclose(
        rotation_of_rpy(rpy), Rotation.from_euler("xyz", rpy).as_matrix(), atol=1e-12
    )


def test_an_orientation_named_after_the_body_is_turned_into_the_transducer() -> None:
    names = np.array(["+x", "-z", "+x", "up"])
    direct, unknown = gravity_of_orientation(names)
    np.testing.assert_array_equal(direct[:3], [[1, 0, 0], [0, 0, -1], [1, 0, 0]])
    assert unknown == ("up",)
    turned, _ = gravity_of_orientation(names[:2], rotation_of_rpy([0.0, 0.0, np.pi]))
    np.testing.assert_allclose(turned, [[-1, 0, 0], [0, 0, -1]], atol=1e-12)


def test_legs_in_the_recipes_order_or_as_met() -> None:
    legs = np.array(["ml", "fl", "ml", "hr"])
    assert legs_in_order(legs, ("fl", "ml", "hl")) == ("fl", "ml")
    assert legs_in_order(legs) == ("ml", "fl", "hr")


def test_an_axis_that_is_said_to_point_up_lies_against_gravity() -> None:
    names = np.array(["+x up", "-z down", " +Y Up", "x_up", "+x sideways"], dtype=object)
    direction, unknown = gravity_of_orientation(names)
    np.testing.assert_array_equal(direction[:4], [[-1, 0, 0], [0, 0, -1], [0, -1, 0], [-1, 0, 0]])
    assert unknown == ("+x sideways",)
