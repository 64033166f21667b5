"""The environments of Gymnasium."""

import threading
import warnings
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import modsearch

gymnasium = pytest.importorskip("gymnasium", "1.4", reason="Gymnasium 1.4 is not installed")
from gymnasium.utils.env_checker import check_env  # noqa: E402
from gymnasium.vector import AutoresetMode  # noqa: E402

IDS = ["modsearch/Design-v0", "modsearch/Design-Flat-v0", "modsearch/Design-Binned-v0"]


class OneModule(modsearch.DesignProblem):
    """Room for one module beside the base; the score is its length."""

    def __init__(self):
        super().__init__("one module", library="seed", max_modules=2)

    def do_evaluate(self, design, fidelity):
        return modsearch.Evaluation(sum(design.parameters), achieved=False)


def make(name="modsearch/Design-v0", **arguments):
    arguments.setdefault("problem", "seed/random_narrow")
    return gymnasium.make(name, **arguments)


@pytest.mark.parametrize("problem", ["seed/random_narrow", "seed/random_obstacles", "workshop/reach", "whitman/3g_3o"])
@pytest.mark.parametrize("name", IDS)
def test_check_env_finds_nothing(name, problem):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(make(name, problem=problem).unwrapped)


@pytest.mark.parametrize("name", IDS)
def test_check_env_finds_nothing_where_there_is_room_for_one_module(name):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(gymnasium.make(name, problem=OneModule()).unwrapped, skip_render_check=True)


def test_the_hybrid_space_has_a_box_for_every_type_and_an_empty_one_without_parameters():
    space = make(problem="workshop/reach").action_space
    library = modsearch.load_library("workshop")
    assert space[0].n == len(library)
    shapes = [box.shape for box in space[1]]
    assert shapes == [(len(library.parameters(name)),) for name in library.types]
    assert (0,) in shapes


def test_observations_of_all_ids_are_one_box_and_the_same():
    first = [make(name).reset(seed=7)[0] for name in IDS]
    np.testing.assert_array_equal(first[0], first[1])
    np.testing.assert_array_equal(first[0], first[2])
    assert all(make(name).observation_space == make().observation_space for name in IDS)


def hinge(proximal, distal):
    """An action of Design-v0 on the library seed: lengths of 0.5 to 1.5 m become -1 to 1."""
    empty = np.zeros(2, np.float32)
    lengths = np.array([2 * (proximal - 1.0), 2 * (distal - 1.0)], np.float32)
    return (1, (np.zeros(1, np.float32), lengths, empty))


def test_the_reward_is_the_score_and_the_episode_ends_when_the_goal_is_reached():
    env = make(problem="seed/fixed")
    env.reset(seed=0)
    _, reward, terminated, truncated, info = env.step(hinge(0.5, np.sqrt(1.25)))
    design = env.unwrapped.design
    assert design.types == ["hinge"]
    assert reward == modsearch.load_problem("seed/fixed").evaluate(design).score == info["score"]
    assert terminated and not truncated and info["achieved"]
    assert reward == pytest.approx(350.0 - 5.0 * (0.5 + np.sqrt(1.25)), abs=1e-5)


def test_the_reward_may_be_what_a_step_adds():
    env = make(problem="seed/fixed", reward="difference")
    env.reset(seed=0)
    problem = modsearch.load_problem("seed/fixed")
    scores = [problem.evaluate([]).score]
    for _ in range(3):
        _, reward, _, _, info = env.step(
            (0, (np.zeros(1, np.float32), np.zeros(2, np.float32), np.zeros(2, np.float32)))
        )
        scores.append(info["score"])
        assert reward == pytest.approx(scores[-1] - scores[-2], abs=1e-12)


def test_a_masked_type_leaves_the_design_as_it_is_and_costs_a_step():
    env = make("modsearch/Design-Binned-v0", problem="workshop/reach", max_steps=3)
    observation, info = env.reset(seed=0)
    masked = int(np.flatnonzero(info["action_mask"] == 0)[0])
    action = np.zeros(env.action_space.shape, np.int64)
    action[0] = masked
    for step in range(3):
        again, reward, terminated, truncated, info = env.step(action)
        np.testing.assert_array_equal(again, observation)
        assert reward == 0.0 and info["masked"] and not terminated
        assert truncated == (step == 2)
        assert len(env.unwrapped.design) == 0


def test_masks_are_those_of_the_problem_and_fit_maskable_agents():
    env = make("modsearch/Design-Binned-v0", problem="workshop/reach", bins=5).unwrapped
    _, info = env.reset(seed=0)
    library = modsearch.load_library("workshop")
    allowed = set(modsearch.load_problem("workshop/reach").successors())
    assert [bool(flag) for flag in info["action_mask"]] == [name in allowed for name in library.types]
    masks = env.action_masks()
    assert masks.dtype == np.bool_ and len(masks) == sum(env.action_space.nvec)
    np.testing.assert_array_equal(masks[: len(library)], info["action_mask"].astype(bool))
    assert masks[len(library) :].all()


def test_the_mask_is_one_that_gymnasium_samples_with():
    env = make("modsearch/Design-v0", problem="workshop/reach")
    _, info = env.reset(seed=0)
    env.action_space.seed(0)
    for _ in range(50):
        assert info["action_mask"][env.action_space[0].sample(info["action_mask"])]


def test_the_flat_space_takes_the_preferred_of_the_types_that_may_follow():
    env = make("modsearch/Design-Flat-v0", problem="workshop/reach").unwrapped
    _, info = env.reset(seed=0)
    action = np.zeros(env.action_space.shape, np.float32)
    masked = np.flatnonzero(info["action_mask"] == 0)
    wanted = int(np.flatnonzero(info["action_mask"])[-1])
    action[masked] = 1.0
    action[wanted] = 0.5
    _, _, _, _, info = env.step(action)
    assert not info["masked"]
    assert env.design.types == [modsearch.load_library("workshop").types[wanted]]


def test_three_forms_of_one_action_are_one_action():
    hybrid, flat, binned = (
        make(name, problem="seed/fixed", **({"bins": 3} if "Binned" in name else {})) for name in IDS
    )
    for env in (hybrid, flat, binned):
        env.reset(seed=0)
    rewards = [
        hybrid.step(hinge(0.5, 1.0))[1],
        flat.step(np.array([0, 1, 0, 0, -1, 0, 0, 0], np.float32))[1],
        binned.step(np.array([1, 0, 1]))[1],
    ]
    assert rewards[0] == rewards[1] == rewards[2]


def test_an_episode_without_room_for_more_is_terminated():
    env = gymnasium.make("modsearch/Design-v0", problem=OneModule())
    env.reset(seed=0)
    _, reward, terminated, truncated, info = env.step(hinge(0.5, 1.0))
    assert reward == pytest.approx(1.5) and terminated and not truncated
    assert not info["action_mask"].any()


def test_what_an_own_problem_raises_ends_the_episode_without_a_reward():
    class Broken(OneModule):
        def do_evaluate(self, design, fidelity):
            if len(design):
                raise ValueError("no")
            return modsearch.Evaluation(0.0, achieved=False)

    env = gymnasium.make("modsearch/Design-v0", problem=Broken())
    env.reset(seed=0)
    _, reward, terminated, truncated, info = env.step(hinge(0.5, 1.0))
    assert reward == 0.0 and truncated and info["failed"] and not terminated and "score" not in info
    assert info["failure"] == "ValueError: no"


def test_an_instance_can_be_fixed_for_all_episodes_or_for_one():
    fixed = make(instance=(1, 7))
    first = fixed.reset(seed=0)[0]
    np.testing.assert_array_equal(first, fixed.reset()[0])
    drawn = make()
    np.testing.assert_array_equal(drawn.reset(seed=0, options={"instance": (1, 7)})[0], first)
    assert not np.array_equal(drawn.reset()[0], first)
    with pytest.raises(ValueError, match="only 'instance'"):
        drawn.reset(options={"goal": 1})


def test_episodes_are_a_function_of_the_seed():
    def goals(seed):
        env = make()
        return [env.reset(seed=seed if i == 0 else None)[0][-6:] for i in range(3)]

    np.testing.assert_array_equal(goals(1), goals(1))
    assert not np.array_equal(goals(1), goals(2))
    assert len({tuple(each) for each in goals(1)}) == 3


def test_a_step_outside_an_episode_and_an_action_of_nan_are_errors():
    env = make().unwrapped
    with pytest.raises(RuntimeError, match="reset comes first"):
        env.step(hinge(0.5, 1.0))
    env.reset(seed=0)
    with pytest.raises(ValueError, match="NaN"):
        env.step(hinge(0.5, float("nan")))
    with pytest.raises(ValueError, match="action 3"):
        env.step((3, hinge(0.5, 1.0)[1]))


@pytest.mark.parametrize(
    "arguments",
    [{"reward": "x"}, {"end_on": "x"}, {"fidelity": "x"}, {"level": "x"}, {"max_steps": 1}, {"actions": "x"}],
)
def test_an_option_that_is_none_is_a_value_error(arguments):
    with pytest.raises(ValueError):
        make(**arguments)


def test_the_design_so_far_is_rendered_as_a_page():
    env = make(problem="seed/random_obstacles", render_mode="html")
    env.reset(seed=0)
    env.step(hinge(0.6, 0.9))
    page = env.render()
    assert page.startswith("<!") and "seed/random_obstacles" in page


@pytest.mark.parametrize("name", IDS)
@pytest.mark.parametrize("threads", [1, 3])
def test_a_vector_does_what_its_environments_do_alone_whatever_the_threads(name, threads):
    n, steps = 5, 40
    vector = gymnasium.make_vec(name, num_envs=n, problem="workshop/reach", threads=threads)
    alone = [gymnasium.make(name, problem="workshop/reach").unwrapped for _ in range(n)]
    observations, infos = vector.reset(seed=11)
    vector.action_space.seed(0)
    for i, env in enumerate(alone):
        np.testing.assert_array_equal(env.reset(seed=11 + i)[0], observations[i])
    over = [False] * n
    for _ in range(steps):
        actions = vector.action_space.sample()
        observations, rewards, terminations, truncations, infos = vector.step(actions)
        each = gymnasium.vector.utils.iterate(vector.action_space, actions)
        for i, (env, action) in enumerate(zip(alone, each, strict=True)):
            if over[i]:
                observation, info = env.reset()
                reward, terminated, truncated = 0.0, False, False
            else:
                observation, reward, terminated, truncated, info = env.step(action)
            over[i] = terminated or truncated
            np.testing.assert_array_equal(observation, observations[i])
            assert (reward, terminated, truncated) == (rewards[i], terminations[i], truncations[i])
            np.testing.assert_array_equal(info["action_mask"], infos["action_mask"][i])
            assert (info["masked"], info["achieved"]) == (infos["masked"][i], infos["achieved"][i])
            assert ("score" in info) == bool(infos.get("_score", np.zeros(n))[i])


def binned_vector(mode, n=3, **arguments):
    arguments.setdefault("max_steps", 4)
    return gymnasium.make_vec(
        "modsearch/Design-Binned-v0", num_envs=n, problem="seed/random_narrow", autoreset_mode=mode, **arguments
    )


LINK = np.tile([0, 0, 0], (3, 1))  # half a metre straight up: reaches no target


def test_same_step_gives_the_last_observation_beside_the_first_of_the_next_episode():
    vector = binned_vector("SameStep")
    next_step = binned_vector("NextStep")
    vector.reset(seed=0)
    next_step.reset(seed=0)
    for _ in range(4):
        observations, rewards, terminations, truncations, infos = vector.step(LINK)
        other = next_step.step(LINK)
    assert truncations.all() and other[3].all()
    for i in range(3):
        np.testing.assert_array_equal(infos["final_obs"][i], other[0][i])
    np.testing.assert_array_equal(infos["final_info"]["score"], other[4]["score"])
    np.testing.assert_array_equal(next_step.step(LINK)[0], observations)
    assert infos["_final_obs"].all() and vector.metadata["autoreset_mode"] == AutoresetMode.SAME_STEP


def same(ours, theirs):
    """Infos are compared where they are said to hold."""
    assert set(ours) == set(theirs)
    for key, value in theirs.items():
        if isinstance(value, dict):
            same(ours[key], value)
            continue
        known = theirs[key if key.startswith("_") else "_" + key]
        assert ours[key].dtype == value.dtype, key
        if key.startswith("_"):
            np.testing.assert_array_equal(ours[key], value)
        else:
            for i in np.flatnonzero(known):
                np.testing.assert_array_equal(ours[key][i], value[i])


@pytest.mark.parametrize("mode", [AutoresetMode.NEXT_STEP, AutoresetMode.SAME_STEP])
def test_steps_and_infos_are_those_of_gymnasiums_own_vector(mode):
    arguments = {"num_envs": 4, "problem": "workshop/reach", "max_steps": 3}
    name = "modsearch/Design-Binned-v0"
    ours = gymnasium.make_vec(name, **arguments, autoreset_mode=mode)
    theirs = gymnasium.make_vec(name, **arguments, vectorization_mode="sync", vector_kwargs={"autoreset_mode": mode})
    same(ours.reset(seed=3)[1], theirs.reset(seed=3)[1])
    ours.action_space.seed(0)
    for _ in range(40):
        action = ours.action_space.sample()
        *ours_said, ours_infos = ours.step(action)
        *theirs_said, theirs_infos = theirs.step(action)
        for one, other in zip(ours_said, theirs_said, strict=True):
            np.testing.assert_array_equal(one, other)
        same(ours_infos, theirs_infos)


def test_disabled_begins_the_episodes_that_the_mask_names():
    vector = binned_vector("Disabled")
    vector.reset(seed=0)
    for _ in range(4):
        observations, _, _, truncations, _ = vector.step(LINK)
    assert truncations.all()
    with pytest.raises(RuntimeError, match="reset comes first"):
        vector.step(LINK)
    again, _ = vector.reset(options={"reset_mask": np.array([True, False, True])})
    np.testing.assert_array_equal(again[1], observations[1])
    assert not np.array_equal(again[0], observations[0])


def test_the_time_limit_of_make_vec_is_native():
    vector = binned_vector("NextStep", max_steps=None, max_episode_steps=2)
    vector.reset(seed=0)
    assert not vector.step(LINK)[3].any()
    assert vector.step(LINK)[3].all()


def test_seeds_may_be_given_one_by_one():
    vector = binned_vector("NextStep")
    np.testing.assert_array_equal(vector.reset(seed=[5, 6, 7])[0], binned_vector("NextStep").reset(seed=5)[0])
    with pytest.raises(ValueError, match="2 seeds for 3 environments"):
        vector.reset(seed=[1, 2])


def test_observations_of_different_steps_share_no_memory():
    vector = binned_vector("NextStep")
    first, infos = vector.reset(seed=0)
    second, _, _, _, more = vector.step(LINK)
    assert not np.shares_memory(first, second)
    assert not np.shares_memory(infos["action_mask"], more["action_mask"])


def test_an_environment_in_use_refuses_a_second_thread():
    inside, leave = threading.Event(), threading.Event()

    class Slow(OneModule):
        def do_evaluate(self, design, fidelity):
            inside.set()
            assert leave.wait(20)
            return super().do_evaluate(design, fidelity)

    for env in (
        gymnasium.make("modsearch/Design-Flat-v0", problem=Slow()).unwrapped,
        gymnasium.make_vec("modsearch/Design-Flat-v0", num_envs=1, problem=Slow()),
    ):
        env.reset(seed=0)
        inside.clear()
        leave.clear()
        with ThreadPoolExecutor(1) as pool:
            first = pool.submit(env.step, env.action_space.sample())
            assert inside.wait(20)
            with pytest.raises(RuntimeError, match="in use by another thread"):
                env.step(env.action_space.sample())
            leave.set()
            first.result()


def test_keyboard_interrupt_in_an_own_problem_is_raised_by_a_step():
    class Interrupted(OneModule):
        def do_evaluate(self, design, fidelity):
            raise KeyboardInterrupt

    for env in (
        gymnasium.make("modsearch/Design-Flat-v0", problem=Interrupted()),
        gymnasium.make_vec("modsearch/Design-Flat-v0", num_envs=4, problem=Interrupted(), threads=2),
    ):
        env.reset(seed=0)
        with pytest.raises(KeyboardInterrupt):
            env.step(env.action_space.sample())
