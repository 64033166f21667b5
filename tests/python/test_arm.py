"""Kinematics as arrays, against arms that are worked out by hand."""

import numpy as np
import pytest

import modsearch

H, L = 0.6, 1.1  # metres before and behind the joint of a hinge


@pytest.fixture(scope="module")
def arm() -> modsearch.Arm:
    """The turning base Rz(q0), then Tz(H) Rx(q1) Tz(L)."""
    return modsearch.load_library("seed").arm([("hinge", [H, L])])


def pose_by_hand(q0: float, q1: float) -> np.ndarray:
    c, s = np.cos, np.sin
    turn = np.array([[c(q0), -s(q0), 0], [s(q0), c(q0), 0], [0, 0, 1]])
    tilt = np.array([[1, 0, 0], [0, c(q1), -s(q1)], [0, s(q1), c(q1)]])
    pose = np.eye(4)
    pose[:3, :3] = turn @ tilt
    pose[:3, 3] = [0, 0, H] + turn @ tilt @ [0, 0, L]
    return pose


def test_forward_is_what_is_worked_out_by_hand(arm):
    for q in ([0.0, 0.0], [0.3, -1.2], [-2.0, 2.5]):
        np.testing.assert_allclose(arm.forward(q), pose_by_hand(*q), atol=1e-14)


def test_a_batch_gives_what_single_postures_give_bit_for_bit(arm):
    q = np.random.default_rng(0).uniform(-np.pi, np.pi, (50, 2))
    np.testing.assert_array_equal(arm.forward(q), [arm.forward(each) for each in q])
    np.testing.assert_array_equal(arm.jacobian(q), [arm.jacobian(each) for each in q])
    np.testing.assert_array_equal(arm.static_torques(q), [arm.static_torques(each) for each in q])
    assert arm.forward(q[:0]).shape == (0, 4, 4)


def test_rows_of_any_memory_layout_and_type_are_taken(arm):
    q = np.random.default_rng(0).uniform(-1, 1, (6, 2))
    expected = arm.forward(q)
    np.testing.assert_array_equal(arm.forward(np.asfortranarray(q)), expected)
    np.testing.assert_array_equal(arm.forward(np.repeat(q, 2, axis=0)[::2]), expected)
    np.testing.assert_array_equal(arm.forward([list(row) for row in q]), expected)
    np.testing.assert_array_equal(arm.forward([0, 1]), arm.forward(np.array([0.0, 1.0])))


def test_jacobian_is_the_derivative_of_the_position_and_the_axes_of_the_joints(arm):
    q = np.array([0.4, 0.9])
    jacobian = arm.jacobian(q)
    h = 1e-6
    for j in range(2):
        step = h * np.eye(2)[j]
        slope = (arm.forward(q + step)[:3, 3] - arm.forward(q - step)[:3, 3]) / (2 * h)
        np.testing.assert_allclose(jacobian[:3, j], slope, atol=1e-9)
    np.testing.assert_allclose(jacobian[3:, 0], [0, 0, 1], atol=1e-15)
    np.testing.assert_allclose(jacobian[3:, 1], [np.cos(q[0]), np.sin(q[0]), 0], atol=1e-15)


def test_frames_begin_with_the_world_and_have_the_joint_axes_as_z(arm):
    frames = arm.frames([0.4, 0.9])
    assert frames.shape == (3, 4, 4)
    np.testing.assert_array_equal(frames[0], np.eye(4))
    np.testing.assert_allclose(frames[2][:3, 2], [np.cos(0.4), np.sin(0.4), 0], atol=1e-15)


def test_the_base_may_stand_anywhere():
    X_WB = np.eye(4)
    X_WB[:3, 3] = [1.0, 2.0, 3.0]
    arm = modsearch.load_library("seed").arm([("hinge", [H, L])], X_WB)
    np.testing.assert_allclose(arm.forward([0.3, 0.2])[:3, 3], pose_by_hand(0.3, 0.2)[:3, 3] + [1, 2, 3], atol=1e-14)
    with pytest.raises(ValueError, match="X_WB: the matrix is no pose"):
        modsearch.load_library("seed").arm([("link", [0.5])], 2 * np.eye(4))


def test_inverse_finds_all_ways_to_reach_a_position(arm):
    target = pose_by_hand(0.3, 0.8)[:3, 3]
    solution = arm.inverse(target, all=True)
    assert solution and solution.exact and solution.position_error < 1e-9
    # The base turns to the target or away from it, the hinge the other way.
    assert len(solution.postures) == 2
    for q in solution.postures:
        np.testing.assert_allclose(arm.forward(q)[:3, 3], target, atol=1e-9)


def test_inverse_says_how_far_it_stays_from_what_is_out_of_reach(arm):
    solution = arm.inverse([0.0, 0.0, H + L + 0.25])
    assert not solution
    assert solution.position_error == pytest.approx(0.25, abs=1e-12)


def test_inverse_of_a_pose_asks_for_the_orientation_too(arm):
    pose = pose_by_hand(0.3, 0.8)
    assert arm.inverse(pose)
    turned = pose.copy()
    turned[:3, :3] = pose[:3, :3] @ np.array([[0, -1, 0], [1, 0, 0], [0, 0, 1]])  # a quarter about the arm's axis
    assert not arm.inverse(turned)
    assert arm.inverse(turned[:3, 3])


def test_inverse_takes_a_goal_of_the_problem_by_name_or_index(fixed, lever):
    arm = fixed.arm(lever)
    np.testing.assert_array_equal(arm.inverse("1").postures, arm.inverse(0).postures)
    with pytest.raises(ValueError, match="goal 'nowhere'"):
        arm.inverse("nowhere")
    with pytest.raises(ValueError, match="goal 1: the problem has 1 goals"):
        arm.inverse(1)


def test_clearance_to_a_sphere_is_a_distance_of_centres_less_both_radii(obstacles):
    # Straight up at (0, 0, z) the arm of radius 0.055 m is nearest to the small sphere of radius 0.2 m at
    # (0.3, 0.3, 0.9); the large one of radius 0.3 m stands at (-0.5, 0.5, 1.2), the box farther.
    arm = obstacles.arm([("link", [1.5])])
    distances = [np.hypot(0.3, 0.3) - 0.2 - 0.055, np.hypot(0.5, 0.5) - 0.3 - 0.055]
    assert arm.clearance([0.0]) == pytest.approx(min(distances), abs=1e-9)
    np.testing.assert_allclose(arm.clearance([[0.0], [1.0]]), [min(distances)] * 2, atol=1e-9)


def test_without_obstacles_the_clearance_is_infinite(arm):
    assert arm.clearance([0.0, 0.0]) == np.inf


def test_static_torques_hold_the_weight_at_its_lever(arm):
    # What the hinge holds: L kilograms with the centre at L / 2, tilted by q1; the base turns about the vertical.
    q1, g = 0.7, 9.81
    held = arm.static_torques([0.3, q1])
    np.testing.assert_allclose(held, [0.0, -L * g * 0.5 * L * np.sin(q1)], atol=1e-12)
    with_load = arm.static_torques([0.3, q1], payload=2.0)
    np.testing.assert_allclose(with_load - held, [0.0, -2.0 * g * L * np.sin(q1)], atol=1e-12)
    pushed = arm.static_torques([0.0, q1], force=[0.0, 0.0, -10.0])
    np.testing.assert_allclose(pushed - arm.static_torques([0.0, q1]), [0.0, -10.0 * L * np.sin(q1)], atol=1e-12)


def test_mass_joints_limits_and_home_are_those_of_the_library(arm):
    assert arm.mass == pytest.approx(H + L, abs=1e-15)
    assert arm.n_joints == 2 and len(arm.joint_names) == 2
    np.testing.assert_allclose(arm.lower_limits, [-np.pi] * 2)
    np.testing.assert_allclose(arm.upper_limits, [np.pi] * 2)
    np.testing.assert_array_equal(arm.home, [0.0, 0.0])


@pytest.mark.parametrize("q", [[0.0], [0.0] * 3, 0.0, np.zeros((2, 3)), np.zeros((1, 1, 2))])
def test_a_posture_of_another_shape_is_a_value_error_that_names_both(arm, q):
    with pytest.raises(ValueError, match=r"the arm has 2 joints: \[2\] or \[n, 2\] is needed"):
        arm.forward(q)


def test_a_joint_position_that_is_no_number_is_a_value_error(arm):
    with pytest.raises(ValueError, match="not a finite number"):
        arm.jacobian([0.0, float("nan")])


def test_arrays_live_on_when_the_arm_is_gone():
    pose = modsearch.load_library("seed").arm([("hinge", [H, L])]).forward([0.3, 0.2])
    np.testing.assert_allclose(pose, pose_by_hand(0.3, 0.2), atol=1e-14)
