"""Problems, libraries, evaluations."""

import pickle

import numpy as np
import pytest

import modsearch
from conftest import LEVER


def algorithm1(modules: int, mass: float) -> float:
    """The score of a design that reaches (docs/formats.md): n counts the base."""
    return 50.0 + 300.0 / 2.0 ** (modules - 2) - 2.0 * (modules - 2) - 5.0 * mass


def test_the_score_of_a_lever_is_that_of_the_formula(fixed, lever):
    evaluation = modsearch.evaluate(fixed, lever)
    assert evaluation.achieved and evaluation.reached and evaluation.why == "none"
    # A hinge of the library seed weighs as many kilograms as its two lengths have metres.
    assert evaluation.score == pytest.approx(algorithm1(2, 0.5 + LEVER), abs=1e-12)
    assert sum(evaluation.terms.values()) == evaluation.score
    assert evaluation.attempt.goal_error <= 1e-3


def test_two_modules_cost_what_the_formula_says(fixed):
    evaluation = fixed.evaluate([("link", [0.5]), ("hinge", [0.5, 1.0])])
    assert evaluation.achieved  # the hinge turns at (0, 0, 1), a metre from the target
    assert evaluation.score == pytest.approx(algorithm1(3, 2.0), abs=1e-12)


def test_a_design_may_be_written_as_a_list_of_tuples(fixed, lever):
    assert fixed.evaluate([("hinge", (0.5, LEVER))]).score == fixed.evaluate(lever).score


def test_the_empty_design_misses_the_target_by_its_whole_distance(fixed):
    evaluation = fixed.evaluate([])
    # The tip stands at the base: |t - p| / |t - b| = 1, and two points come back for the module that is not there.
    assert evaluation.score == pytest.approx(-1.0 + 2.0, abs=1e-12)
    assert not evaluation.achieved and not evaluation.reached


@pytest.mark.parametrize(
    ("design", "complaint"),
    [
        ([("hinge", [9.0, 1.0])], r"module 0 of the design \(hinge\): proximal is 9 m, not in \[0.5, 1.5\]"),
        ([("hinge", [0.5])], "1 parameters given, the type has 2"),
        ([("hook", [])], "'hook' is no type of library 'seed', which has link, hinge, rotary"),
        ([("link", [float("nan")])], "length is nan m"),
        ([("link", [0.5])] * 10, "11 modules with the base, at most 10"),
    ],
)
def test_a_design_outside_the_search_space_is_a_value_error_with_module_value_and_limit(fixed, design, complaint):
    with pytest.raises(ValueError, match=complaint):
        fixed.evaluate(design)


def test_a_fidelity_that_is_none_is_a_value_error(fixed, lever):
    with pytest.raises(ValueError, match="'half' is not one of poses, screen, full"):
        fixed.evaluate(lever, fidelity="half")


def test_evaluations_survive_pickle_with_their_postures_and_path(fixed, lever):
    evaluation = fixed.with_level("path").evaluate(lever)
    again = pickle.loads(pickle.dumps(evaluation))
    assert again.score == evaluation.score and again.terms == evaluation.terms
    np.testing.assert_array_equal(again.postures, evaluation.postures)
    np.testing.assert_array_equal(again.attempt.path.waypoints, evaluation.attempt.path.waypoints)
    assert again.attempt.work == evaluation.attempt.work


def test_postures_put_the_tip_at_the_goal(fixed, lever):
    evaluation = fixed.evaluate(lever)
    tip = fixed.arm(lever).forward(evaluation.postures[0])
    assert np.linalg.norm(tip[:3, 3] - fixed.goals[0].position) <= 1e-3
    assert fixed.goals[0].contains(tip)


def test_goals_say_where_the_tip_has_to_be(fixed):
    (goal,) = fixed.goals
    np.testing.assert_array_equal(goal.position, [1.0, 0.0, 1.0])
    assert goal.tolerances == {"r_sph": (0.0, 0.001)}
    assert (goal.id, goal.type) == ("1", "reach")


def test_a_problem_may_have_goals_of_ones_own(fixed):
    goals = [modsearch.Goal("low", [0.8, 0.0, 0.6], tolerance=0.01), modsearch.Goal("high", [0.8, 0.0, 1.2])]
    problem = fixed.with_goals(goals, name="shelves")
    assert problem.name == "shelves" and [goal.id for goal in problem.goals] == ["low", "high"]
    solution = modsearch.solve(problem, evaluations=2000)
    assert solution.achieved and len(solution.postures) == 2
    arm = problem.arm(solution.design)
    tips = arm.forward(solution.postures)[:, :3, 3]
    assert np.linalg.norm(tips[0] - [0.8, 0.0, 0.6]) <= 0.01
    assert np.linalg.norm(tips[1] - [0.8, 0.0, 1.2]) <= 0.001
    assert problem.reference is None
    with pytest.raises(TypeError, match="not loaded from a file"):
        pickle.dumps(problem)
    with pytest.raises(ValueError, match="neither a file nor an ID"):
        solution.to_json()


def test_a_goal_that_is_a_pose_asks_for_the_orientation():
    pose = np.eye(4)
    pose[:3, 3] = [0.1, 0.2, 0.3]
    goal = modsearch.Goal("tool", pose, tolerance=0.01, angle=0.1)
    assert goal.tolerances == {"r_sph": (0.0, 0.01), "Theta_R": (0.0, 0.1)}

    def turned(angle):
        c, s = np.cos(angle), np.sin(angle)
        X = pose.copy()
        X[:3, :3] = [[1, 0, 0], [0, c, -s], [0, s, c]]
        return X

    assert goal.contains(turned(0.09)) and not goal.contains(turned(0.11))
    with pytest.raises(ValueError, match="'follow' is not one of at, reach"):
        modsearch.Goal("tool", pose, type="follow")
    with pytest.raises(ValueError, match="a pose is a homogeneous matrix"):
        modsearch.Goal("tool", [1.0, 2.0])


def test_a_problem_without_goals_is_a_value_error(fixed):
    with pytest.raises(ValueError, match="goal"):
        fixed.with_goals([])


def test_instances_differ_by_seed_and_index_and_are_the_same_again():
    def target(instance):
        return tuple(modsearch.load_problem("seed/random_narrow", instance).goals[0].position)

    assert target((0, 1)) == target((0, 1))
    assert len({target((0, 1)), target((0, 2)), target((1, 1))}) == 3


@pytest.mark.parametrize("instance", [5, (1,), (1, 2, 3), (-1, 0), (0.5, 1), "01", (2**64, 0)])
def test_an_instance_that_is_none_is_a_value_error(instance):
    with pytest.raises(ValueError, match="not \\(seed, index\\)"):
        modsearch.load_problem("seed/random_narrow", instance)


def test_an_instance_of_a_problem_that_has_only_one_is_a_value_error():
    with pytest.raises(ValueError, match="is not sampled"):
        modsearch.load_problem("seed/fixed", instance=(1, 0))


def test_a_file_that_is_missing_is_a_file_error_that_names_it():
    with pytest.raises(modsearch.FileError, match="nowhere.json"):
        modsearch.load_problem("nowhere.json")


def test_a_path_object_names_a_file(tmp_path):
    file = tmp_path / "library.json"
    file.write_text(modsearch.convert("seed", "modsearch"))
    assert modsearch.load_library(file).types == modsearch.load_library("seed").types


def test_a_problem_survives_pickle_with_instance_and_level(obstacles):
    again = pickle.loads(pickle.dumps(obstacles.with_level("path")))
    assert again.level == "path" and again.instance == (0, 3) and again.reference == "seed/random_obstacles"
    np.testing.assert_array_equal(again.goals[0].position, obstacles.goals[0].position)


def test_successors_are_the_types_that_fit(fixed):
    assert fixed.successors() == ["link", "hinge", "rotary"]
    assert fixed.successors([("link", [0.5])] * 9) == []


def test_a_library_says_what_its_types_are():
    seed = modsearch.load_library("seed")
    assert seed.types == ["link", "hinge", "rotary"] and len(seed) == 3
    assert seed.parameters("link") == [("length", "m", 0.5, 1.5)]
    assert (seed.role("link"), seed.role("hinge")) == ("link", "joint")
    with pytest.raises(ValueError, match="'hook'"):
        seed.parameters("hook")


def test_what_is_built_in_can_be_listed():
    assert "seed/fixed" in modsearch.list_problems()
    assert "workshop" in modsearch.list_libraries()
    names = [entry.name for entry in modsearch.list_solvers()]
    assert {"auto", "ga", "per-sequence", "policy:FILE"} <= set(names)


def test_a_task_that_is_proved_infeasible_says_why(fixed):
    assert fixed.infeasible is None
    whys = [modsearch.load_problem("whitman/5g_5o", (0, i)).infeasible for i in range(20)]
    assert any(why and "goal" in why for why in whys)


def test_verify_plans_a_path_and_looks_at_it(fixed, lever):
    verification = modsearch.verify(fixed, lever)
    assert verification and verification.level == "path" and verification.findings == []
    np.testing.assert_array_equal(verification.path.waypoints[0], fixed.arm(lever).home)


def test_verify_finds_what_a_design_misses(fixed):
    verification = modsearch.verify(fixed, [("link", [0.5])])
    assert not verification and verification.level == "none" and verification.findings


def test_convert_writes_the_arm_of_a_design_as_urdf(tmp_path, lever):
    file = tmp_path / "lever.json"
    file.write_text(lever.to_json("seed"))
    assert "<robot" in modsearch.convert(file, "urdf", library="seed")
    with pytest.raises(ValueError, match="'stl' is not one of"):
        modsearch.convert(file, "stl")
