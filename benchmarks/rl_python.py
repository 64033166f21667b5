#!/usr/bin/python3
"""One P-DQN update in Python and PyTorch, as users of the published implementations know it: the yardstick beside
rl_benchmark. Same sizes: 16 observations, three actions of two parameters, value network [128], actor [128, 64] with a
fixed linear passthrough, batch 128, one thread. Needs python3-torch and numpy.

    OMP_NUM_THREADS=1 /usr/bin/python3 benchmarks/rl_python.py            # microseconds per update: median, least, largest
    ... --multi-pass                                             # MP-DQN
"""

import argparse
import statistics
import time

import torch
from torch import nn

STATES, COUNTS, ROWS = 16, [2, 2, 2], 128
PARAMETERS = sum(COUNTS)


def perceptron(widths):
    layers = []
    for n_in, n_out in zip(widths, widths[1:]):
        layers += [nn.Linear(n_in, n_out), nn.ReLU()]
    return nn.Sequential(*layers[:-1])


class Actor(nn.Module):
    def __init__(self):
        super().__init__()
        self.network = perceptron([STATES, 128, 64, PARAMETERS])
        self.register_buffer("passthrough", 0.1 * torch.randn(STATES, PARAMETERS))

    def forward(self, s):
        return self.network(s) + s @ self.passthrough


class Values(nn.Module):
    """Q(s, x) of every action: one pass that sees all parameters, or one per action that sees its own."""

    def __init__(self, multi_pass):
        super().__init__()
        self.network = perceptron([STATES + PARAMETERS, 128, len(COUNTS)])
        masks = torch.zeros(len(COUNTS), 1, PARAMETERS)
        first = 0
        for k, count in enumerate(COUNTS):
            masks[k, 0, first:first + count] = 1.0
            first += count
        self.register_buffer("masks", masks)
        self.multi_pass = multi_pass

    def forward(self, s, x):
        if not self.multi_pass:
            return self.network(torch.cat((s, x), 1))
        inputs = torch.cat([torch.cat((s, x * mask), 1) for mask in self.masks])
        passes = self.network(inputs).view(len(COUNTS), s.shape[0], len(COUNTS))
        return passes.diagonal(dim1=0, dim2=2)


class Pdqn:
    def __init__(self, multi_pass, gamma=0.95, clip=10.0, value_tau=0.01, actor_tau=0.001):
        self.gamma, self.clip, self.taus = gamma, clip, (value_tau, actor_tau)
        self.q, self.q_target = Values(multi_pass), Values(multi_pass)
        self.mu, self.mu_target = Actor(), Actor()
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
        return int(self.q(s.unsqueeze(0), x).argmax())


def random_batch():
    return (2.0 * torch.rand(ROWS, STATES) - 1.0, torch.randint(len(COUNTS), (ROWS, 1)),
            2.0 * torch.rand(ROWS, PARAMETERS) - 1.0, torch.randn(ROWS, 1), 2.0 * torch.rand(ROWS, STATES) - 1.0,
            (torch.rand(ROWS, 1) < 0.2).float())


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
    options = parser.parse_args()
    torch.set_num_threads(1)
    torch.manual_seed(1)
    agent = Pdqn(options.multi_pass)
    batch = random_batch()
    print("MP-DQN" if options.multi_pass else "P-DQN", "in PyTorch", torch.__version__)
    measure("update", lambda: agent.update(*batch), 50)
    measure("act", lambda: agent.act(batch[0][0]), 500)


if __name__ == "__main__":
    main()
