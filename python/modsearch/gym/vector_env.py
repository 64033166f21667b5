"""Many environments at a time, stepped in C++."""

from __future__ import annotations

import os
from typing import Any, Literal

import numpy as np
from gymnasium.utils import seeding
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray

from .. import _core
from .._core import Design, DesignProblem
from .actions import Form, actions_of
from .env import Level, Observation, observation_box, problem_steps

Told = dict[str, tuple[NDArray[Any], NDArray[np.bool_]]]
"""What there is to tell by name, and of which environments."""

# Of an episode that has just begun these are told, too; the others are not known yet.
_ALWAYS = {"action_mask": True, "masked": True, "failed": True, "achieved": True, "score": False, "failure": False}


def _infos(told: Told) -> dict[str, Any]:
    """As Gymnasium has them: beside each entry, under its name with "_", the environments it speaks of."""
    infos: dict[str, Any] = {}
    for key, (values, known) in told.items():
        if known.any():
            infos[key] = values
            infos["_" + key] = known.copy()
    return infos


def _begun(values: NDArray[Any], ended: NDArray[np.bool_]) -> NDArray[Any]:
    """Flags of the episodes that follow those that ended: nothing has happened in them."""
    return np.where(ended, False, values) if values.dtype == np.bool_ else values


class DesignVectorEnv(VectorEnv[Observation, Any, NDArray[Any]]):
    """`num_envs` environments like DesignEnv, with its arguments, that take a step at once and without the interpreter.

    Environment i does what a DesignEnv does that was reset with the same seed, whatever the others do and however many
    `threads` there are. `autoreset_mode`: "NextStep", "SameStep" or "Disabled", as in Gymnasium; with the last,
    reset(options={"reset_mask": [num_envs]}) begins the episodes that ended. `max_episode_steps` is `max_steps`.
    """

    metadata = {"render_modes": [], "autoreset_mode": AutoresetMode.NEXT_STEP}

    def __init__(
        self,
        problem: str | os.PathLike[str] | DesignProblem,
        *,
        num_envs: int = 1,
        threads: int = 1,
        actions: Form = "hybrid",
        bins: int = 11,
        instance: tuple[int, int] | None = None,
        reward: Literal["score", "difference"] = "score",
        end_on: Literal["reached", "achieved"] = "reached",
        fidelity: Literal["full", "screen"] = "full",
        level: Level | None = None,
        max_steps: int | None = None,
        max_episode_steps: int | None = None,
        autoreset_mode: str | AutoresetMode = AutoresetMode.NEXT_STEP,
        render_mode: None = None,
    ) -> None:
        if render_mode is not None:
            raise ValueError("render_mode: many environments cannot be rendered at once")
        self._autoreset = AutoresetMode(autoreset_mode)
        steps = max_steps if max_episode_steps is None else max_episode_steps
        if steps is None:
            steps = problem_steps(problem, instance)
        options = (problem, instance, reward, end_on, fidelity, level, steps)
        self._episodes = _core._VectorEpisodes(*options, num_envs, threads, self._autoreset.value)
        one = _core._Episodes(*options)
        self._actions = actions_of(actions, one.counts, bins)
        self._masks = np.zeros((num_envs, len(one.counts)), np.int8)
        self._seeded = False
        self.num_envs = num_envs
        self.metadata = {**self.metadata, "autoreset_mode": self._autoreset}
        self.render_mode = None
        self.single_action_space = self._actions.space
        self.single_observation_space = observation_box(one.observation_size)
        self.action_space = batch_space(self.single_action_space, num_envs)
        self.observation_space = batch_space(self.single_observation_space, num_envs)

    def reset(
        self, *, seed: int | list[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Begins an episode in every environment, or in those that options["reset_mask"] marks. `seed`: of each, or of
        the first, the others counting on. Raises ValueError for other options or another number of seeds."""
        if isinstance(seed, int | np.integer):
            self._seed([int(seed) + i for i in range(self.num_envs)])
        elif seed is not None:
            self._seed(list(seed))
        elif not self._seeded:
            self._seed([None] * self.num_envs)
        options = dict(options or {})
        which = options.pop("reset_mask", None)
        if options:
            raise ValueError(f"options: {sorted(options)} are not known, only 'reset_mask'")
        observations, self._masks = self._episodes.reset(
            None if which is None else np.ascontiguousarray(which, np.bool_)
        )
        nothing = np.zeros(self.num_envs, np.bool_)
        told = {
            "action_mask": self._masks.copy(),
            "masked": nothing,
            "failed": nothing.copy(),
            "achieved": nothing.copy(),
        }
        return observations, _infos({key: (values, np.ones(self.num_envs, np.bool_)) for key, values in told.items()})

    def step(
        self, actions: Any
    ) -> tuple[Observation, NDArray[np.float64], NDArray[np.bool_], NDArray[np.bool_], dict[str, Any]]:
        """Takes an action in every environment; see DesignEnv.step."""
        types, parameters = self._actions.decode_batch(actions, self._masks)
        result = self._episodes.step(types, parameters)
        observations, rewards, terminated, truncated, masks, masked, failed, scores, achieved, failures, last = result
        self._masks = masks
        every = np.ones(self.num_envs, np.bool_)
        told = {
            "action_mask": (masks.copy(), every),
            "masked": (masked, every),
            "failed": (failed, every),
            "achieved": (achieved, every),
            "score": (scores, ~np.isnan(scores)),
            "failure": (np.array(failures, dtype=object), failed),
        }
        ended = terminated | truncated
        if last is None or not ended.any():
            return observations, rewards, terminated, truncated, _infos(told)
        # SameStep: what is told of the episodes that ended goes to final_info, the rest speaks of those that began.
        last_observations, last_masks = last
        final = {**told, "action_mask": (last_masks, every)}
        infos = _infos(
            {key: (_begun(values, ended), known & (~ended | _ALWAYS[key])) for key, (values, known) in told.items()}
        )
        infos["final_info"] = _infos({key: (values, known & ended) for key, (values, known) in final.items()})
        infos["_final_info"] = ended
        infos["final_obs"] = np.empty(self.num_envs, dtype=object)
        infos["_final_obs"] = ended.copy()
        for i in np.flatnonzero(ended):
            infos["final_obs"][i] = last_observations[i].copy()
        return observations, rewards, terminated, truncated, infos

    def action_masks(self) -> NDArray[np.bool_]:
        """Which discrete choices may be taken now [num_envs, ..]; see DesignEnv.action_masks."""
        return self._actions.masks(self._masks)

    def design(self, index: int) -> Design:
        """The design so far of one environment."""
        return self._episodes.design(index)

    def close_extras(self, **kwargs: Any) -> None:
        """Nothing is open but memory."""

    def _seed(self, seeds: list[int | None]) -> None:
        if len(seeds) != self.num_envs:
            raise ValueError(f"{len(seeds)} seeds for {self.num_envs} environments")
        streams = [int(seeding.np_random(seed)[0].integers(2**63)) for seed in seeds]
        self._episodes.seed(streams)
        self._seeded = True
