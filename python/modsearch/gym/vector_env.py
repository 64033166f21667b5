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
        return observations, self._nothing()

    def step(
        self, actions: Any
    ) -> tuple[Observation, NDArray[np.float64], NDArray[np.bool_], NDArray[np.bool_], dict[str, Any]]:
        """Takes an action in every environment; see DesignEnv.step."""
        types, parameters = self._actions.decode_batch(actions, self._masks)
        result = self._episodes.step(types, parameters)
        observations, rewards, terminated, truncated, masks, masked, failed, scores, achieved, failures, last = result
        self._masks = masks
        infos = self._infos(masked, failed, achieved, scores)
        if failed.any():
            infos["failure"] = np.array(failures, dtype=object)
            infos["_failure"] = failed.copy()
        if last is not None:
            self._finish(infos, terminated | truncated, last)
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

    def _infos(
        self,
        masked: NDArray[np.bool_],
        failed: NDArray[np.bool_],
        achieved: NDArray[np.bool_],
        scores: NDArray[np.float64],
    ) -> dict[str, Any]:
        """As Gymnasium has them: beside each entry, under its name with "_", which environments it speaks of."""
        infos: dict[str, Any] = {
            "action_mask": self._masks.copy(),
            "masked": masked,
            "failed": failed,
            "achieved": achieved,
        }
        for key in list(infos):
            infos["_" + key] = np.ones(self.num_envs, np.bool_)
        known = ~np.isnan(scores)
        if known.any():
            infos["score"] = scores
            infos["_score"] = known
        return infos

    def _nothing(self) -> dict[str, Any]:
        """The infos of episodes that have just begun."""
        n = self.num_envs
        masked, failed, achieved = (np.zeros(n, np.bool_) for _ in range(3))
        return self._infos(masked, failed, achieved, np.full(n, np.nan))

    def _finish(self, infos: dict[str, Any], ended: NDArray[np.bool_], last: Observation) -> None:
        """SameStep: what belongs to the episodes that ended goes to final_info, and the rest speaks of the new ones."""
        if not ended.any():
            return
        final: dict[str, Any] = {}
        for key in ("masked", "failed", "achieved", "score"):
            if key not in infos:
                continue
            final[key] = infos[key].copy()
            final["_" + key] = infos["_" + key] & ended
            infos[key] = np.where(ended, np.nan if key == "score" else False, infos[key])
            infos["_" + key] = infos["_" + key] & ~ended if key == "score" else infos["_" + key]
        infos["final_info"] = final
        infos["_final_info"] = ended.copy()
        observations = np.empty(self.num_envs, dtype=object)
        for i in np.flatnonzero(ended):
            observations[i] = last[i].copy()
        infos["final_obs"] = observations
        infos["_final_obs"] = ended.copy()
