#!/usr/bin/env python3
"""Ends `solve --checkpoint`, `train` and `compare` at random moments and in random ways, goes on with them, and looks
whether what comes out in the end is what a run gives that nobody disturbed: nothing that was finished is lost, nothing
counts twice, nothing but readings of the clock differs.

Ways: SIGKILL; SIGKILL with a tail of the file cut off that was being written; a file that may not grow; a full disk
(a small tmpfs, where one can be mounted); each with stderr as it is, closed or full.

  kill_points.py PROGRAM FOLDER [--kills N] [--seed S] [--only solve|train|compare]
"""
import argparse
import csv
import glob
import io
import json
import os
import random
import resource
import shutil
import signal
import struct
import subprocess
import sys
import time

WAYS = ("kill", "kill", "torn", "limit", "disk")
ERRORS = ("kept", "closed", "full")


class Wrong(Exception):
    """Something that must not happen."""


def without_columns(path, columns):
    """A CSV file as rows, without some of its columns."""
    rows = list(csv.reader(io.StringIO(open(path, encoding="utf-8", newline="").read())))
    kept = [i for i, name in enumerate(rows[0]) if name not in columns]
    return [[row[i] for i in kept] for row in rows]


def without_clock(value):
    """JSON without whatever is a reading of the clock."""
    if isinstance(value, dict):
        return {k: without_clock(v) for k, v in value.items() if "econds" not in k and k != "computationTime"}
    return [without_clock(v) for v in value] if isinstance(value, list) else value


def load(path):
    with open(path, encoding="utf-8") as stream:
        return without_clock(json.load(stream))


def difference(a, b):
    """Where two values differ first, in words."""
    if isinstance(a, dict) and isinstance(b, dict) and a.keys() == b.keys():
        return next(f"/{k}{difference(a[k], b[k])}" for k in a if a[k] != b[k])
    if isinstance(a, list) and isinstance(b, list) and len(a) == len(b):
        return next(f"/{i}{difference(a[i], b[i])}" for i in range(len(a)) if a[i] != b[i])
    return f" is {str(a)[:500]} instead of {str(b)[:500]}"


def cut(path, size):
    """Takes the last `size` bytes off a file."""
    with open(path, "r+b") as stream:
        stream.truncate(max(0, os.path.getsize(path) - size))


class Search:
    """solve --checkpoint: everything is in the checkpoint."""

    name = "solve"

    def __init__(self, solver, problem, evaluations):
        self.words = ["solve", problem, "--solver", solver, "--evaluations", str(evaluations), "--seed", "3", "--json",
                      "--checkpoint", "search.bin", "--checkpoint-seconds", "0.1", "--resume", "--out", "out"]
        self.title = f"solve --solver {solver}"

    def command(self, _):
        return self.words

    def finished(self, folder):
        return set()

    def tear(self, folder, rng):
        path = f"{folder}/search.bin"
        if not os.path.exists(path):
            return None
        cut(path, rng.randint(1, 2000))
        return path

    def results(self, folder):
        return {"solution": load(f"{folder}/out/solution.json"),
                "trace": without_columns(f"{folder}/out/trace.csv", {"seconds"})}


class Training:
    """train: policy, log and curves."""

    name = "train"

    def __init__(self, agent, problem):
        self.words = ["train", problem, "--agent", agent, "--seed", "5", "--checkpoint-seconds", "0.1", "--out", "out"]
        self.title = f"train --agent {agent}"

    def command(self, folder):
        return self.words + (["--resume"] if os.path.exists(f"{folder}/out/checkpoint.bin") else [])

    def finished(self, folder):
        return set()

    def tear(self, folder, rng):
        choices = [p for p in (f"{folder}/out/checkpoint.bin", f"{folder}/out/training.csv") if os.path.exists(p)]
        choices += sorted(glob.glob(f"{folder}/out/events.out.tfevents.*"))[-1:]
        if not choices:
            return None
        path = rng.choice(choices)
        cut(path, rng.randint(1, 200))
        return path

    def results(self, folder):
        policy = load(f"{folder}/out/policy.json")
        with open(f"{folder}/out/" + policy["weights"]["file"], "rb") as stream:
            weights = stream.read()
        return {"policy": policy, "weights": weights,
                "log": without_columns(f"{folder}/out/training.csv", {"training_s"}), "curves": curves(f"{folder}/out")}


def fields(message):
    """Of a protocol buffer: (number, value)."""
    at = 0

    def varint():
        nonlocal at
        value = shift = 0
        while True:
            byte = message[at]
            at += 1
            value |= (byte & 0x7F) << shift
            shift += 7
            if byte < 0x80:
                return value

    while at < len(message):
        key = varint()
        if key & 7 == 0:
            yield key >> 3, varint()
            continue
        size = {1: 8, 5: 4}.get(key & 7) or varint()
        yield key >> 3, message[at:at + size]
        at += size


def curves(folder):
    """What TensorBoard shows of the event files: {tag: {step: value}}."""
    shown = {}
    for path in sorted(glob.glob(f"{folder}/events.out.tfevents.*")):
        data = open(path, "rb").read()
        at = 0
        while at + 12 <= len(data):
            size = struct.unpack_from("<Q", data, at)[0]
            if at + 16 + size > len(data):
                break  # torn
            event = dict(fields(data[at + 12:at + 12 + size]))
            at += 16 + size
            step = event.get(2, 0)
            if 7 in event:  # a session begins: what was there from this step on is void
                shown = {tag: {s: v for s, v in points.items() if s < step} for tag, points in shown.items()}
            if 5 in event:
                value = dict(fields(dict(fields(event[5]))[1]))
                points = shown.setdefault(value[1].decode(), {})
                if step in points:
                    raise Wrong(f"{path}: step {step} of {value[1].decode()} is there twice")
                points[step] = value[2]
    return shown


class Comparison:
    """compare: the journal and what is made of it."""

    name = "compare"
    study = {
        "modsearch": 1, "name": "kills",
        "problems": [{"problem": "seed/fixed"}, {"problem": "seed/random_obstacles", "instances": {"seed": 1, "count": 3}}],
        "solvers": [{"solver": "random"}, {"solver": "per-sequence:starts=2,inner=own"}, {"solver": "ga"},
                    {"solver": "policy", "label": "agent",
                     "train": {"agent": "mpdqn:preset=best", "episodes": 60, "on": "seed/fixed"}}],
        "seeds": {"first": 0, "count": 3}, "budget": {"evaluations": 400},
    }

    def __init__(self, jobs):
        self.words = ["compare", "study.json", "--jobs", str(jobs), "--resume", "--out", "out"]
        self.title = f"compare --jobs {jobs}"

    def command(self, folder):
        with open(f"{folder}/study.json", "w", encoding="utf-8") as stream:
            json.dump(self.study, stream)
        return self.words

    @staticmethod
    def events(folder):
        path = f"{folder}/out/events.jsonl"
        if not os.path.exists(path):
            return []
        lines = open(path, encoding="utf-8").read().split("\n")[:-1]  # behind the last line's end: torn
        return [json.loads(line) for line in lines]

    def finished(self, folder):
        done = [event["cell"] for event in self.events(folder) if event.get("event") == "done"]
        if len(done) != len(set(done)):
            raise Wrong("a cell is done twice in the journal")
        return set(done)

    def tear(self, folder, rng):
        path = f"{folder}/out/events.jsonl"
        if not os.path.exists(path):
            return None
        # A write is torn within the lines of one moment: those behind the last end of a cell but one stay.
        text = open(path, "rb").read()
        cut(path, rng.randint(1, max(1, len(text) - text.rfind(b"\n", 0, len(text) - 1) - 1)))
        return path

    def results(self, folder):
        clocks = {"seconds", "cpu_seconds"}
        out = f"{folder}/out"
        policies = {os.path.basename(p): load(p)["weights"]["crc32c"] for p in glob.glob(f"{out}/policies/*.json")}
        return {"runs": without_columns(f"{out}/runs.csv", clocks), "traces": without_columns(f"{out}/traces.csv", clocks),
                "scores": without_columns(f"{out}/scores.csv", set()), "policies": policies,
                "done": self.finished(folder)}


class Disk:
    """A file system of its own whose size can be changed; the plain folder where none can be mounted."""

    def __init__(self, folder):
        self.folder = folder
        os.makedirs(folder)
        self.mounted = os.geteuid() == 0 and self.mount("size=256m")

    def mount(self, options):
        return subprocess.run(["mount", "-t", "tmpfs", "-o", options, "modsearch-kills", self.folder],
                              stderr=subprocess.DEVNULL).returncode == 0

    def limit(self, free):
        used = sum(os.path.getsize(p) for p in glob.glob(f"{self.folder}/**", recursive=True) if os.path.isfile(p))
        subprocess.run(["mount", "-o", f"remount,size={(used + free) // 4096 * 4096 + 16384}", self.folder], check=True)

    def widen(self):
        subprocess.run(["mount", "-o", "remount,size=256m", self.folder], check=True)

    def remove(self):
        if self.mounted:
            subprocess.run(["umount", "-l", self.folder], check=True)
        shutil.rmtree(self.folder)


class Runs:
    def __init__(self, program, folder, rng):
        self.program = program
        self.folder = folder
        self.rng = rng
        self.counts = {}

    def count(self, what):
        self.counts[what] = self.counts.get(what, 0) + 1

    def start(self, subject, folder, errors="kept", largest=None):
        def prepare():
            if largest is not None:
                resource.setrlimit(resource.RLIMIT_FSIZE, (largest, largest))
            if errors == "closed":
                os.close(2)

        stderr = open("/dev/full" if errors == "full" else f"{self.folder}/stderr.txt", "wb")
        with stderr:
            return subprocess.Popen([self.program, *subject.command(folder)], cwd=folder, stdin=subprocess.DEVNULL,
                                    stdout=subprocess.DEVNULL, stderr=stderr, preexec_fn=prepare)

    def whole(self, subject, folder):
        """Runs until the end; gives the status."""
        status = self.start(subject, folder).wait()
        if status < 0 or status >= 128:
            raise Wrong(f"status {status}")
        return status

    def disturb(self, subject, disk, seconds):
        """One disturbance. Whether the run was over before it came."""
        rng = self.rng
        way = rng.choice(WAYS)
        if way == "disk" and not disk.mounted:
            way = "limit"
        errors = rng.choice(ERRORS)
        largest = None
        if way == "limit":
            largest = rng.choice((rng.randint(1, 2000), rng.randint(2000, 200000)))
        if way == "disk":
            disk.limit(rng.choice((rng.randint(0, 4096), rng.randint(0, 400000))))
        child = self.start(subject, disk.folder, errors, largest)
        delay = rng.uniform(0.0, seconds)
        try:
            status = child.wait(timeout=delay)
        except subprocess.TimeoutExpired:
            child.send_signal(signal.SIGKILL)
            child.wait()
            status = -signal.SIGKILL
        if way == "disk":
            disk.widen()
        if status >= 128 or (status < 0 and status != -signal.SIGKILL):
            raise Wrong(f"{way}, stderr {errors}: status {status}")
        if status == 2 and way not in ("limit", "disk"):
            raise Wrong(f"{way}, stderr {errors}: refused: {open(self.folder + '/stderr.txt').read()}")
        over = status in (0, 1)
        if over:
            return True
        torn = subject.tear(disk.folder, rng) if way == "torn" else None
        self.count(f"{subject.name}: {'torn' if torn else 'kill' if way == 'torn' else way}")
        self.count(f"stderr {errors}")
        if torn and torn.endswith(".bin"):
            self.refused(subject, disk.folder)
            os.remove(torn)
        return False

    def refused(self, subject, folder):
        """A checkpoint is written whole or not at all; one that was torn by force is refused in one sentence."""
        status = self.whole(subject, folder)
        said = open(f"{self.folder}/stderr.txt", encoding="utf-8").read()
        known = ("truncated", "cut off", "is not an archive", "empty")
        if status != 2 or said.count("\n") != 1 or not any(word in said for word in known):
            raise Wrong(f"a torn checkpoint gives status {status}: {said}")
        self.count(f"{subject.name}: torn checkpoint refused")

    def go_on(self, subject, folder):
        """Goes on until the end."""
        status = self.whole(subject, folder)
        if status not in (0, 1):
            raise Wrong(f"status {status} at the end: {open(self.folder + '/stderr.txt').read()}")

    def round(self, subject, expected, seconds, most):
        """One run that is disturbed up to `most` times. How often it was."""
        disk = Disk(f"{self.folder}/round")
        n = 0
        try:
            known = set()
            while n < most and not self.disturb(subject, disk, seconds):
                n += 1
                now = subject.finished(disk.folder)
                if len(known - now) > 1:  # a torn line takes one cell with it
                    raise Wrong(f"{len(known - now)} finished cells are lost")
                known = now
                if self.rng.random() < 0.3:
                    break
            before = subject.finished(disk.folder)
            self.go_on(subject, disk.folder)
            if not before <= subject.finished(disk.folder):
                raise Wrong("finished cells are lost")
            for what, value in subject.results(disk.folder).items():
                if value != expected[what]:
                    raise Wrong(f"{what}{difference(value, expected[what])}")
            self.count(f"{subject.name}: rounds with equal results")
        except Wrong:
            shutil.copytree(disk.folder, f"{self.folder}/wrong", dirs_exist_ok=True)
            raise
        finally:
            disk.remove()
        return n


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("folder", help="to work in; emptied")
    parser.add_argument("--kills", type=int, default=200)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--only", choices=("solve", "train", "compare"))
    arguments = parser.parse_args()

    subjects = [Search("ga", "seed/random_obstacles", 20000), Search("anneal", "seed/random_obstacles", 20000),
                Search("mcts", "seed/random_obstacles", 6000),
                Training("mpdqn:preset=best,episodes=600,final_episodes=1,evaluate_every=10", "seed/random_narrow"),
                Comparison(1), Comparison(3)]
    subjects = [s for s in subjects if arguments.only in (None, s.name)]
    shutil.rmtree(arguments.folder, ignore_errors=True)
    os.makedirs(arguments.folder)
    runs = Runs(os.path.abspath(arguments.program), os.path.abspath(arguments.folder), random.Random(arguments.seed))

    expected = []
    for number, subject in enumerate(subjects):
        folder = f"{runs.folder}/whole{number}"
        os.makedirs(folder)
        begun = time.monotonic()
        status = runs.whole(subject, folder)
        if status not in (0, 1):
            raise Wrong(f"{subject.title}: status {status}: {open(runs.folder + '/stderr.txt').read()}")
        expected.append((subject.results(folder), time.monotonic() - begun))
        print(f"{subject.title}: {expected[-1][1]:.2f} s undisturbed", flush=True)

    kills = 0
    number = 0
    while kills < arguments.kills:
        which = number % len(subjects)
        number += 1
        results, seconds = expected[which]
        try:
            kills += runs.round(subjects[which], results, seconds, min(6, arguments.kills - kills))
        except Wrong as wrong:
            print(f"WRONG: {subjects[which].title}, round {number}: {wrong}")
            return 1
    print(f"{kills} disturbances in {number} rounds, all results equal")
    for what in sorted(runs.counts):
        print(f"  {what}: {runs.counts[what]}")
    shutil.rmtree(runs.folder)
    return 0


if __name__ == "__main__":
    sys.exit(main())
