#!/usr/bin/env python3
"""Certificates of libraries as nobody should build them: reversed joints, rotations in decimals, bodies beside the chain,
fixed angles, continuous and limited joints, placed bases, no mass. What `modsearch certify` calls proved has to be
accepted by modsearch-check, and no solver may find a design that scores more.

usage: odd_certificates.py [--count N] [--seed S] [--seconds T] [--attack S] MODSEARCH [MODSEARCH ...]

Several programs are measured side by side on the same problems, one run after the other. --attack: seconds that each of
ga, random and anneal may look for a design above the bound (default: they do not try). Exit status 1 where a claim does
not hold."""

import argparse
import json
import math
import random
import subprocess
import sys
import tempfile
import time
from pathlib import Path

IDENTITY = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]


def times(a, b):
    return [[sum(a[i][k] * b[k][j] for k in range(3)) for j in range(3)] for i in range(3)]


def about(axis, angle):
    c, s = math.cos(angle), math.sin(angle)
    i, j = (axis + 1) % 3, (axis + 2) % 3
    turn = [row[:] for row in IDENTITY]
    turn[i][i], turn[i][j], turn[j][i], turn[j][j] = c, -s, s, c
    return turn


class Draw:
    """Everything a problem is made of, from one stream of random numbers."""

    def __init__(self, seed):
        self.rng = random.Random(seed)

    def rotation(self):
        """Right angles as they are, as cosines give them, and any angle in few or all decimals."""
        kind = self.rng.randrange(5)
        if kind == 0:
            return IDENTITY
        turn = IDENTITY
        for _ in range(self.rng.randrange(1, 4)):
            angle = self.rng.choice([0.5, 1.0, 1.5]) * math.pi if kind <= 2 else self.rng.uniform(-3.0, 3.0)
            turn = times(turn, about(self.rng.randrange(3), angle))
        if kind == 1:
            turn = [[float(round(entry)) for entry in row] for row in turn]
        if kind == 4:
            turn = [[round(entry, 7) for entry in row] for row in turn]
        return turn

    def pose(self, move, turn=None):
        turn = self.rotation() if turn is None else turn
        return [turn[i] + [move[i]] for i in range(3)] + [[0, 0, 0, 1]]

    def body(self, name, length, mass):
        half = {**length, "scale": 0.5} if isinstance(length, dict) else 0.5 * length
        cylinder = {"type": "cylinder", "parameters": {"r": 0.05, "z": length},
                    "pose": [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, half], [0, 0, 0, 1]]}
        shapes = [cylinder] if self.rng.random() < 0.8 else []
        return {"ID": name, "mass": mass, "inertia": [[0, 0, 0]] * 3, "r_com": [0, 0, 0], "connectors": [],
                "collision": shapes}

    def limits(self):
        if self.rng.random() < 0.3:
            return "continuous", {"limits": {"positionLower": -10, "positionUpper": 10}}
        lower, upper = self.rng.choice([(-math.pi, math.pi), (-2.0, 1.5), (-6.5, 6.5), (-0.5, 2.5)])
        return "revolute", {"limits": {"positionLower": lower, "positionUpper": upper}}

    def joint(self, name, parent, child, at, fixed):
        joint = {"ID": name, "parent": parent, "child": child, "passive": False,
                 "poseParent": self.pose([0, 0, at]), "poseChild": self.pose([0, 0, 0])}
        if self.rng.random() < 0.3:  # against the chain
            joint.update(parent=child, child=parent, poseParent=joint["poseChild"], poseChild=joint["poseParent"])
        if fixed:
            return {**joint, "type": "fixed", **({"angle": self.rng.uniform(-3, 3)} if self.rng.random() < 0.5 else {})}
        kind, limits = self.limits()
        return {**joint, "type": kind, **limits}

    def connector(self, name, pose, gender, kind="arm"):
        return {"ID": name, "pose": pose, "gender": gender, "type": kind, "size": [0.1]}

    def module(self, name, massless):
        rng = self.rng
        parameters, lengths = [], []
        for b in range(rng.randrange(1, 3)):
            if rng.random() < 0.6:
                least = rng.uniform(0.05, 0.3)
                parameters.append({"name": f"p{b}", "unit": "m", "lower": least, "upper": least + rng.choice([0, 0.5])})
                lengths.append({"parameter": f"p{b}", "scale": 1.0, "offset": 0.0})
            else:
                lengths.append(rng.uniform(0.1, 0.5))
        bodies = []
        for b, length in enumerate(lengths):
            mass = 0.0 if massless else ({**length, "scale": 2.0} if isinstance(length, dict) else rng.uniform(0.0, 1.0))
            bodies.append(self.body(f"b{b}", length, mass))
        joints = [self.joint(f"j{b}", f"b{b}", f"b{b + 1}", lengths[b], rng.random() < 0.3)
                  for b in range(len(lengths) - 1)]
        if rng.random() < 0.3:  # a body beside the chain
            bodies.append(self.body("beside", 0.1, 0.0 if massless else 0.1))
            joints.append(self.joint("held", "b0", "beside", 0.0, True))
        down = [[1, 0, 0, 0], [0, -1, 0, 0], [0, 0, -1, 0], [0, 0, 0, 1]]
        bodies[0]["connectors"].append(self.connector("in", down, "h"))
        bodies[len(lengths) - 1]["connectors"].append(self.connector("out", self.pose([0, 0, lengths[-1]]), "h"))
        return {"header": {"ID": name, "name": name}, "parameters": parameters, "bodies": bodies, "joints": joints}

    def base(self):
        down = [[1, 0, 0, 0], [0, -1, 0, 0], [0, 0, -1, 0], [0, 0, 0, 1]]
        ground, turn = self.body("ground", 0.1, 0.0), self.body("turn", 0.1, 0.0)
        ground["collision"] = turn["collision"] = []
        ground["connectors"] = [self.connector("base", down, "f", "base")]
        turn["connectors"] = [self.connector("out", self.pose([0, 0, 0]), "h")]
        joint = {"ID": "j", "parent": "ground", "child": "turn", "passive": False, "type": "continuous",
                 "limits": {"positionLower": -10, "positionUpper": 10}, "poseParent": self.pose([0, 0, 0], IDENTITY), "poseChild": self.pose([0, 0, 0], IDENTITY)}
        return {"header": {"ID": "base", "name": "base"}, "bodies": [ground, turn], "joints": [joint]}

    def task(self):
        rng = self.rng
        direction = [rng.gauss(0, 1) for _ in range(3)]
        goals = []
        for g in range(rng.randrange(1, 3)):
            away = rng.uniform(0.2, 1.0) / math.sqrt(sum(x * x for x in direction))
            goals.append({"ID": str(g), "type": "reach", "goalPose": {
                "nominal": self.pose([away * x for x in direction], IDENTITY),
                "toleranceProjection": ["r_sph"], "tolerance": [[0, rng.choice([0.001, 0.05])]]}})
            direction = [rng.gauss(0, 1) for _ in range(3)]
        obstacles = []
        for o in range(rng.randrange(3)):
            place = [rng.uniform(-0.6, 0.6) for _ in range(3)]
            size = rng.uniform(0.03, 0.2)
            shape = rng.choice([("sphere", {"r": size}), ("box", {"x": size, "y": 0.1, "z": 2 * size}),
                                ("cylinder", {"r": 0.5 * size, "z": size})])
            obstacles.append({"ID": str(o), "name": f"o{o}", "collision": [
                {"type": shape[0], "parameters": shape[1], "pose": self.pose(place)}]})
        constraints = [{"type": "allGoalsFulfilled"}]
        if rng.random() < 0.5:
            constraints.append({"type": "basePlacement", "pose": {"nominal": self.pose([rng.uniform(-0.1, 0.1), 0, 0])}})
        return {"header": {"ID": "odd"}, "obstacles": obstacles, "constraints": constraints, "goals": goals}

    def problem(self):
        rng = self.rng
        massless = rng.random() < 0.1
        modules = [self.base()] + [self.module(f"m{k}", massless) for k in range(rng.randrange(1, 3))]
        scoring = rng.choice([{"type": "algorithm1"},
                              {"type": "weighted", "reached": 100, "distance": 1, "module": rng.choice([0, 5]),
                               "mass": rng.choice([0, 1, 3]), "collision": 10}])
        return {"modsearch": 1, "task": self.task(), "library": {"modules": modules}, "maxModules": 3,
                "collision": rng.choice(["none", "posture", "posture+self"]), "scoring": scoring}


def run(*command):
    done = subprocess.run([str(part) for part in command], capture_output=True, text=True, check=False)
    return done.returncode, done.stdout, done.stderr


class Tally:
    def __init__(self):
        self.proved = self.closed = self.refused = self.beaten = self.not_proved = self.not_covered = 0
        self.seconds = 0.0
        self.reasons = []  # why something was not proved


def attack(program, problem, bound, seconds):
    """The best score that a solver finds above the bound, if any."""
    for solver in ("ga", "random", "anneal"):
        _, out, _ = run(program, "solve", problem, "--solver", solver, "--seconds", seconds, "--json", "--quiet")
        answer = json.loads(out)
        if answer["achieved"] and (bound is None or answer["score"] > bound + 1e-9):
            return f"{solver} scores {answer['score']}"
    return None


def judge(program, problem, folder, options, tally):
    certificate = folder / "certificate.json"
    certificate.unlink(missing_ok=True)
    begun = time.perf_counter()
    status, out, err = run(program, "certify", problem, "--gap", "1e-3", "--seconds", options.seconds, "--json", "--out",
                           certificate)
    tally.seconds += time.perf_counter() - begun
    if status == 2:
        tally.not_covered += 1
        return None if "nothing is proved" in err else f"certify: {err.strip()}"
    claim = json.loads(out)
    if not claim["proved"]:
        tally.not_proved += 1
        tally.reasons.append(claim.get("open", ""))
        return None
    status, _, _ = run(program.parent / "modsearch-check", certificate)
    if status != 0:
        tally.refused += 1
        return "called proved, and refused"
    tally.proved += 1
    tally.closed += claim["closed"]
    if options.attack > 0:
        better = attack(program, problem, claim.get("upper"), options.attack)
        if better:
            tally.beaten += 1
            return f"the bound is {claim.get('upper')}, and {better}"
    return None


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=100)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--seconds", type=float, default=2.0)
    parser.add_argument("--attack", type=float, default=0.0)
    parser.add_argument("--keep", type=Path, help="folder for the problems whose claims do not hold")
    parser.add_argument("program", type=Path, nargs="+")
    options = parser.parse_args()
    tallies = [Tally() for _ in options.program]
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for i in range(options.count):
            text = json.dumps(Draw(options.seed * 1_000_000 + i).problem())
            problem = folder / "problem.json"
            problem.write_text(text)
            for program, tally in zip(options.program, tallies):
                wrong = judge(program.resolve(), problem, folder, options, tally)
                if wrong:
                    print(f"{program}, problem {i}: {wrong}", flush=True)
                    if options.keep:
                        (options.keep / f"{i}.json").write_text(text)
    for program, tally in zip(options.program, tallies):
        print(f"{program}: {tally.proved} proved and accepted ({tally.closed} to the gap), {tally.not_proved} not proved, "
              f"{tally.not_covered} not covered, {tally.refused} refused, {tally.beaten} beaten; {tally.seconds:.1f} s")
        for reason in sorted(set(tally.reasons)):
            print(f"  not proved: {reason}")
    return 1 if any(tally.refused or tally.beaten for tally in tallies) else 0


if __name__ == "__main__":
    sys.exit(main())
