"""An agent that knows nothing but the mask, for one environment and for many at a time.

Run: python gym_random_agent.py
"""

import gymnasium
import numpy as np

import modsearch  # noqa: F401  registers the environments

# 1. One environment: every step places a module; its type and its lengths are one action.
env = gymnasium.make("modsearch/Design-v0", problem="seed/random_narrow")
env.action_space.seed(0)
reached = 0
returns = []
for episode in range(100):
    observation, info = env.reset(seed=episode)
    over, total = False, 0.0
    while not over:
        types, parameters = env.action_space.spaces
        action = (types.sample(info["action_mask"]), parameters.sample())
        observation, reward, terminated, truncated, info = env.step(action)
        over, total = terminated or truncated, total + reward
    reached += info["achieved"]
    returns.append(total)
print(f"one at a time: {reached} of 100 targets reached, mean return {np.mean(returns):.1f}")

# 2. Many at a time, stepped in C++: what each does depends on its seed alone.
vector = gymnasium.make_vec("modsearch/Design-Flat-v0", problem="seed/random_narrow", num_envs=64)
vector.action_space.seed(0)
vector.reset(seed=0)
episodes = 0
for _ in range(100):
    _, _, terminations, truncations, _ = vector.step(vector.action_space.sample())
    episodes += int((terminations | truncations).sum())
print(f"64 at a time: {episodes} episodes in 6400 steps")
