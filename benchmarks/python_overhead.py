"""What calls from Python cost, and how many steps the environments take, in processor time.

Run: python benchmarks/python_overhead.py
"""

import time
from collections.abc import Callable

import gymnasium
import numpy as np

import modsearch

FAMILY = "seed/random_narrow"


def microseconds(call: Callable[[], object], n: int) -> float:
    """Of one call; the least of seven rounds of `n`."""
    rounds = []
    for _ in range(7):
        began = time.process_time()
        for _ in range(n):
            call()
        rounds.append((time.process_time() - began) / n * 1e6)
    return min(rounds)


def one(name: str, seconds: float = 5.0) -> float:
    """Steps of one environment with random actions per second."""
    env = gymnasium.make(name, problem=FAMILY)
    env.action_space.seed(0)
    env.reset(seed=0)
    began, steps = time.process_time(), 0
    while time.process_time() - began < seconds:
        _, _, terminated, truncated, _ = env.step(env.action_space.sample())
        steps += 1
        if terminated or truncated:
            env.reset()
    return steps / (time.process_time() - began)


def many(name: str, seconds: float = 5.0, **arguments: object) -> float:
    """The same of 64 at a time."""
    env = gymnasium.make_vec(name, num_envs=64, problem=FAMILY, **arguments)
    env.action_space.seed(0)
    env.reset(seed=0)
    began, steps = time.process_time(), 0
    while time.process_time() - began < seconds:
        env.step(env.action_space.sample())
        steps += 64
    return steps / (time.process_time() - began)


problem = modsearch.load_problem("seed/fixed")
listed = [("hinge", [0.5, np.sqrt(1.25)])]
design = modsearch.Design(listed)
arm = problem.arm(design)
q = np.random.default_rng(0).uniform(-np.pi, np.pi, (10_000, 2))
print(f"evaluate, a Design        {microseconds(lambda: problem.evaluate(design), 50_000):8.2f} us")
print(f"evaluate, a list          {microseconds(lambda: problem.evaluate(listed), 20_000):8.2f} us")
print(f"forward, one posture      {microseconds(lambda: arm.forward(q[0]), 50_000):8.2f} us")
print(f"forward, of a batch       {microseconds(lambda: arm.forward(q), 50) / len(q):8.3f} us")
for form in ("", "-Flat", "-Binned"):
    name = f"modsearch/Design{form}-v0"
    print(f"{name:<25} {one(name):8.0f} steps/s alone, {many(name):8.0f} as 64 at a time")
sync = many("modsearch/Design-Flat-v0", vectorization_mode="sync")
print(f"Flat, SyncVectorEnv of 64 {sync:8.0f} steps/s")
