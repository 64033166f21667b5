"""One environment at a time."""

from __future__ import annotations

import os
from typing import Any, Literal

import gymnasium
import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from .. import _core
from .._core import Design, DesignProblem
from .actions import Form, actions_of

Observation = NDArray[np.float32]
Level = Literal["none", "posture", "posture+self", "path"]


def problem_steps(problem: str | os.PathLike[str] | DesignProblem, instance: tuple[int, int] | None) -> int:
    """Steps after which an episode is cut off where nobody says so: four times the modules that there is room for."""
    known = problem if isinstance(problem, DesignProblem) else _core.load_problem(problem, instance)
    return max(2, 4 * (known.max_modules - 1))


def observation_box(size: int) -> spaces.Box[np.float32]:
    """Numbers about in [-1, 1]; what lies beyond the ends of the space is clipped."""
    return spaces.Box(-_core._Episodes.bound, _core._Episodes.bound, (size,), np.float32)


class DesignEnv(gymnasium.Env[Observation, Any]):
    """The search for a design as a Markov decision process: every step places a module at the tip.

    `problem`: a file, an ID, or a problem. A sampled family gives a new instance for every episode, unless `instance`
    (seed, index) fixes it; reset(options={"instance": (1, 7)}) gives that one for an episode. `actions`: "hybrid",
    "flat" or "binned" (the registered IDs differ in nothing else), with `bins` values of each parameter for the last.
    `reward`: "score", the design's score after every step, as in the report, or "difference", what the step has added
    to it. `end_on`: an episode ends when the goals are "reached", as in the report, or when the design is "achieved".
    `fidelity`: "screen" plans no path. `level`: another collision level than the problem's. `max_steps`: an episode is
    truncated after so many steps (default: four times as many as modules have room).

    Observation: float32, the modules so far, the share of modules placed, and the instance (docs/python.md). An action
    whose type may not follow is no error: the design stays, the step counts, the reward is 0 and info["masked"] is
    True. An episode is terminated when its end is reached, and when there is no room for another module. `info` has
    "action_mask" (int8 [K], for Discrete.sample), "masked", "failed" (the problem raised an exception, which ends the
    episode; "failure" has its words), "achieved", and "score" once there is one.
    """

    metadata = {"render_modes": ["html"], "render_fps": 1}

    def __init__(
        self,
        problem: str | os.PathLike[str] | DesignProblem,
        *,
        actions: Form = "hybrid",
        bins: int = 11,
        instance: tuple[int, int] | None = None,
        reward: Literal["score", "difference"] = "score",
        end_on: Literal["reached", "achieved"] = "reached",
        fidelity: Literal["full", "screen"] = "full",
        level: Level | None = None,
        max_steps: int | None = None,
        render_mode: Literal["html"] | None = None,
    ) -> None:
        if render_mode not in (None, "html"):
            raise ValueError(f"render_mode {render_mode!r} is not one of html")
        steps = problem_steps(problem, instance) if max_steps is None else max_steps
        self._problem = problem
        self._episodes = _core._Episodes(problem, instance, reward, end_on, fidelity, level, steps)
        self._actions = actions_of(actions, self._episodes.counts, bins)
        self._mask = np.zeros(len(self._episodes.counts), np.int8)
        self._seeded = False
        self.render_mode = render_mode
        self.action_space = self._actions.space
        self.observation_space = observation_box(self._episodes.observation_size)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Begins an episode. `seed`: all episodes from here on are a function of it. `options`: {"instance": (seed,
        index)}, for this episode only. Raises ValueError for other options, and for an instance of one problem."""
        super().reset(seed=seed)
        if seed is not None or not self._seeded:
            self._episodes.seed(int(self.np_random.integers(2**63)))
            self._seeded = True
        options = dict(options or {})
        instance = options.pop("instance", None)
        if options:
            raise ValueError(f"options: {sorted(options)} are not known, only 'instance'")
        if instance is None:
            observation, self._mask = self._episodes.reset()
        else:
            observation, self._mask = self._episodes.reset_to(self._problem, instance)
        return observation, self._info(False, False, None, False)

    def step(self, action: Any) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """Places a module. Raises RuntimeError outside an episode, ValueError for an action that is none (NaN)."""
        k, x_k = self._actions.decode(action, self._mask)
        result = self._episodes.step(k, x_k)
        observation, reward, terminated, truncated, self._mask, masked, failed, score, achieved, failure = result
        info = self._info(masked, failed, score, achieved)
        if failed:
            info["failure"] = failure
        return observation, reward, terminated, truncated, info

    def action_masks(self) -> NDArray[np.bool_]:
        """Which discrete choices may be taken now: [K]; with binned actions [K + P * bins], as MaskablePPO wants it."""
        return self._actions.masks(self._mask)

    @property
    def design(self) -> Design:
        """The design so far."""
        return self._episodes.design

    def render(self) -> str | None:
        """With render_mode "html" the design so far as a 3-D page of its own, else nothing."""
        return self._episodes.render() if self.render_mode == "html" else None

    def _info(self, masked: bool, failed: bool, score: float | None, achieved: bool) -> dict[str, Any]:
        info = {"action_mask": self._mask.copy(), "masked": masked, "failed": failed, "achieved": achieved}
        if score is not None:
            info["score"] = score
        return info
