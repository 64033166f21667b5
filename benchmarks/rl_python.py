#!/usr/bin/python3
"""One P-DQN update in Python and PyTorch, as users of the published implementations know it: the yardstick beside
rl_benchmark. Same sizes: 16 observations, three actions of two parameters, value network [128], actor [128, 64] with a
fixed linear passthrough, batch 128, one thread. Needs python3-torch and numpy.

    OMP_NUM_THREADS=1 /usr/bin/python3 benchmarks/rl_python.py   # microseconds per update: median, least, largest
    ... --multi-pass                                             # MP-DQN
    ... --steps 5000                                             # seconds of a training of so many steps on seed/fixed

A training here costs acting, replay and learning only: its environment is free, its states are random numbers. That
flatters Python, whose environment would be slower than ours.
"""

import argparse
import statistics
import time

import numpy as np
import torch
from torch import nn

STATES, COUNTS, ROWS = 16, [2, 2, 2], 128
REPORT_STATES, REPORT_COUNTS = 36, [1, 2, 2]  # of the report's environment: link, rotary, hinge


def perceptron(widths):
    layers = []
    for n_in, n_out in zip(widths, widths[1:]):
        layers += [nn.Linear(n_in, n_out), nn.ReLU()]
    return nn.Sequential(*layers[:-1])


class Actor(nn.Module):
    def __init__(self, states, counts):
        super().__init__()
        self.network = perceptron([states, 128, 64, sum(counts)])
        self.register_buffer("passthrough", 0.1 * torch.randn(states, sum(counts)))

    def forward(self, s):
        return self.network(s) + s @ self.passthrough


class Values(nn.Module):
    """Q(s, x) of every action: one pass that sees all parameters, or one per action that sees its own."""

    def __init__(self, states, counts, multi_pass):
        super().__init__()
        self.network = perceptron([states + sum(counts), 128, len(counts)])
        masks = torch.zeros(len(counts), 1, sum(counts))
        first = 0
        for k, count in enumerate(counts):
            masks[k, 0, first:first + count] = 1.0
            first += count
        self.register_buffer("masks", masks)
        self.n_actions = len(counts)
        self.multi_pass = multi_pass

    def forward(self, s, x):
        if not self.multi_pass:
            return self.network(torch.cat((s, x), 1))
        inputs = torch.cat([torch.cat((s, x * mask), 1) for mask in self.masks])
        passes = self.network(inputs).view(self.n_actions, s.shape[0], self.n_actions)
        return passes.diagonal(dim1=0, dim2=2)


class Pdqn:
    def __init__(self, states, counts, multi_pass, gamma=0.95, clip=10.0, value_tau=0.01, actor_tau=0.001):
        self.gamma, self.clip, self.taus = gamma, clip, (value_tau, actor_tau)
        self.q, self.q_target = Values(states, counts, multi_pass), Values(states, counts, multi_pass)
        self.mu, self.mu_target = Actor(states, counts), Actor(states, counts)
        self.q_target.load_state_dict(self.q.state_dict())
        self.mu_target.load_state_dict(self.mu.state_dict())
        self.q_adam = torch.optim.Adam(self.q.parameters(), lr=1e-3)
        self.mu_adam = torch.optim.Adam(self.mu.parameters(), lr=1e-4)

    def update(self, s, k, x, reward, s_next, terminal):
        with torch.no_grad():
            best = self.q_target(s_next, self.mu_target(s_next)).max(1, keepdim=True)[0]
            y = reward + (1.0 - terminal) * self.gamma * best
        loss = nn.functional.mse_loss(self.q(s, x).gather(1, k), y)
        self.q_adam.zero_grad()
        loss.backward()
        nn.utils.clip_grad_norm_(self.q.parameters(), self.clip)
        self.q_adam.step()

        proposals = self.mu(s)
        at = proposals.detach().requires_grad_(True)
        g, = torch.autograd.grad(self.q(s, at).sum() / len(s), at)
        at = at.detach()
        g = g * torch.where(g > 0.0, (1.0 - at) / 2.0, (at + 1.0) / 2.0)  # inverting gradients
        self.mu_adam.zero_grad()
        proposals.backward(-g)
        nn.utils.clip_grad_norm_(self.mu.parameters(), self.clip)
        self.mu_adam.step()
        with torch.no_grad():
            for target, source, tau in zip((self.q_target, self.mu_target), (self.q, self.mu), self.taus):
                for to, new in zip(target.parameters(), source.parameters()):
                    to.mul_(1.0 - tau).add_(new, alpha=tau)

    @torch.no_grad()
    def act(self, s):
        x = self.mu(s.unsqueeze(0)).clamp(-1.0, 1.0)
        return int(self.q(s.unsqueeze(0), x).argmax()), x[0]


def random_batch():
    return (2.0 * torch.rand(ROWS, STATES) - 1.0, torch.randint(len(COUNTS), (ROWS, 1)),
            2.0 * torch.rand(ROWS, sum(COUNTS)) - 1.0, torch.randn(ROWS, 1), 2.0 * torch.rand(ROWS, STATES) - 1.0,
            (torch.rand(ROWS, 1) < 0.2).float())


def training(agent, steps, epsilon=0.99, capacity=300_000):
    """Seconds of `steps` steps: an action, an experience, a batch, an update; the first epsilon of the report's."""
    states, parameters = REPORT_STATES, sum(REPORT_COUNTS)
    ring = [np.zeros((capacity, n), np.float32) for n in (states, 1, parameters, 1, states, 1)]
    ring[1] = ring[1].astype(np.int64)
    rng = np.random.default_rng(1)
    s = rng.standard_normal(states, np.float32)
    start = time.perf_counter()
    for step in range(steps):
        if rng.random() < epsilon:
            k, x = int(rng.integers(len(REPORT_COUNTS))), rng.uniform(-1.0, 1.0, parameters).astype(np.float32)
        else:
            k, x = agent.act(torch.from_numpy(s))
        s_next = rng.standard_normal(states, np.float32)
        for column, value in zip(ring, (s, k, x, 1.0, s_next, rng.random() < 0.2)):
            column[step % capacity] = value
        s = s_next
        if step + 1 < ROWS:
            continue
        rows = rng.integers(min(step + 1, capacity), size=ROWS)
        agent.update(*(torch.from_numpy(column[rows]) for column in ring))
    return time.perf_counter() - start


def measure(what, function, repeats, rounds=9):
    times = []
    for _ in range(rounds):
        start = time.process_time()
        for _ in range(repeats):
            function()
        times.append((time.process_time() - start) / repeats * 1e6)
    print(f"{what:<8} {statistics.median(times):8.1f} us   ({min(times):.1f} to {max(times):.1f})")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--multi-pass", action="store_true", help="MP-DQN instead of P-DQN")
    parser.add_argument("--steps", type=int, default=0, help="time a training of so many steps instead")
    options = parser.parse_args()
    torch.set_num_threads(1)
    torch.manual_seed(1)
    if options.steps:
        agent = Pdqn(REPORT_STATES, REPORT_COUNTS, options.multi_pass)
        print(f"{training(agent, options.steps):.3f}")
        return
    agent = Pdqn(STATES, COUNTS, options.multi_pass)
    batch = random_batch()
    print("MP-DQN" if options.multi_pass else "P-DQN", "in PyTorch", torch.__version__)
    measure("update", lambda: agent.update(*batch), 50)
    measure("act", lambda: agent.act(batch[0][0]), 500)


if __name__ == "__main__":
    main()
