"""Laws of SE(2), on random poses."""

from itertools import pairwise
from math import pi

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from slam.compiled import wrapped
from slam.pose import Pose2D, path_lengths, relative_poses, stack_poses, wrap_angle, wrap_angles

coordinates = st.floats(-100, 100)
poses = st.builds(Pose2D, coordinates, coordinates, st.floats(-pi, pi))


def close(a: Pose2D, b: Pose2D) -> bool:
    return a.distance(b) < 1e-9 and abs(wrap_angle(a.theta - b.theta)) < 1e-9


@given(poses, poses, poses)
def test_composition_is_associative(a: Pose2D, b: Pose2D, c: Pose2D) -> None:
    assert close((a @ b) @ c, a @ (b @ c))


@given(poses)
def test_identity_and_inverse_are_those_of_a_group(a: Pose2D) -> None:
    assert close(a @ Pose2D(), a)
    assert close(Pose2D() @ a, a)
    assert close(a @ a.inverse(), Pose2D())
    assert close(a.inverse() @ a, Pose2D())


@given(poses, poses)
def test_between_gives_the_relative_pose(a: Pose2D, b: Pose2D) -> None:
    assert close(a @ a.between(b), b)


@given(poses, poses, coordinates, coordinates)
def test_transform_is_an_action_of_the_group(a: Pose2D, b: Pose2D, x: float, y: float) -> None:
    point = np.array([[x, y]])
    np.testing.assert_allclose((a @ b).transform(point), a.transform(b.transform(point)), atol=1e-9)


@given(poses)
def test_rotation_is_orthonormal(a: Pose2D) -> None:
    np.testing.assert_allclose(a.rotation @ a.rotation.T, np.eye(2), atol=1e-12)
    assert np.linalg.det(a.rotation) > 0


@given(st.floats(-1000, 1000))
def test_wrap_angle_keeps_the_direction(angle: float) -> None:
    wrapped = wrap_angle(angle)
    assert -pi < wrapped <= pi
    np.testing.assert_allclose([np.cos(wrapped), np.sin(wrapped)], [np.cos(angle), np.sin(angle)], atol=1e-9)


@given(st.floats(-1000, 1000))
def test_compiled_code_wraps_an_angle_as_python_does(angle: float) -> None:
    assert abs(wrapped(angle)) < pi + 1e-9
    assert abs(wrap_angle(wrapped(angle) - angle)) < 1e-9


@given(st.lists(st.floats(-1000, 1000)))
def test_angles_of_an_array_are_wrapped_as_each_alone(angles: list[float]) -> None:
    wrapped = wrap_angles(np.array(angles))
    assert (np.abs(wrapped) <= pi).all()
    for one, angle in zip(wrapped.tolist(), angles, strict=True):
        assert abs(wrap_angle(one - angle)) < 1e-9


@given(st.lists(poses))
def test_poses_are_converted_to_arrays_and_back(several: list[Pose2D]) -> None:
    rows = stack_poses(several)
    assert rows.shape == (len(several), 3)
    assert [Pose2D.from_array(row) for row in rows] == several
    assert all((pose.as_array() == row).all() for pose, row in zip(several, rows, strict=True))


@given(poses, st.lists(poses))
def test_relative_poses_are_the_motions_from_the_origin(origin: Pose2D, several: list[Pose2D]) -> None:
    for row, pose in zip(relative_poses(origin.as_array(), stack_poses(several)), several, strict=True):
        assert close(Pose2D.from_array(row), origin.between(pose))


@given(st.lists(poses, min_size=1))
def test_the_length_of_a_path_is_the_sum_of_its_steps(path: list[Pose2D]) -> None:
    steps = [a.distance(b) for a, b in pairwise(path)]
    np.testing.assert_allclose(path_lengths(stack_poses(path)), [sum(steps[:k]) for k in range(len(path))], atol=1e-9)


def test_a_known_pose_is_transformed() -> None:
    T_map_laser = Pose2D(1.0, 2.0, pi / 2) @ Pose2D(0.5, 0.0, 0.0)
    assert close(T_map_laser, Pose2D(1.0, 2.5, pi / 2))
    assert abs(Pose2D(1.0, 2.0, pi / 2).bearing(Pose2D(0.0, 2.0)) - pi / 2) < 1e-12
