"""Searches: the library's solvers, own problems and solvers, stopping."""

import json
import pickle
import signal
import subprocess
import sys
import threading
import time
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import modsearch
from modsearch.program import program


class Mast(modsearch.DesignProblem):
    """The tallest mast of at most 4 kg: stretched out, an arm of the library seed is as high as it is heavy."""

    def __init__(self, faults=()):
        super().__init__("mast", library="seed", max_modules=4, context=[4.0])
        self.calls = 0
        self.faults = list(faults)

    def do_evaluate(self, design, fidelity):
        self.calls += 1
        if self.faults:
            raise self.faults.pop(0)
        arm = self.library.arm(design)
        height = arm.forward(np.zeros(arm.n_joints))[2, 3]
        fits = arm.mass <= 4.0
        return modsearch.Evaluation(height if fits else 4.0 - arm.mass, achieved=fits)


class Luck(modsearch.Solver):
    """Random search, as the library has it."""

    name = "luck"

    def do_solve(self, problem, meter, rng):
        self.meter = meter
        while meter.evaluate(problem, modsearch.random_design(problem, rng)):
            pass
        return "out of luck"


@pytest.mark.parametrize("solver", ["auto", "random", "ga:population=20", "per-sequence:inner=ipopt"])
def test_a_search_gives_what_the_command_line_gives_bit_for_bit(solver):
    words = ["--instance", "0:3", "--solver", solver, "--seed", "5", "--evaluations", "300", "--json", "--quiet"]
    done = subprocess.run(
        [program("modsearch"), "solve", "seed/random_obstacles", *words], capture_output=True, text=True, check=False
    )
    said = json.loads(done.stdout)
    problem = modsearch.load_problem("seed/random_obstacles", (0, 3))
    solution = modsearch.solve(problem, solver, evaluations=300, seed=5)
    assert json.loads(solution.design.to_json(problem)) == said["design"]
    assert solution.score == said["score"]
    assert (solution.stop, solution.evaluations, solution.reason) == (said["stop"], said["evaluations"], said["reason"])
    assert solution.outcomes == said["outcomes"]


def test_equal_arguments_give_equal_solutions_and_other_seeds_others(fixed):
    def design(seed):
        return modsearch.solve(fixed, "random", evaluations=50, seed=seed).design

    assert design(1) == design(1) != design(2)


def test_the_search_ends_at_the_first_achieved_design_or_at_a_score(fixed):
    first = modsearch.solve(fixed, "ga", evaluations=100_000, until="achieved")
    assert first.achieved and first.stop == "target score" and first.outcomes["achieved"] == 1
    good = modsearch.solve(fixed, "ga", evaluations=100_000, until=300.0)
    assert good.score >= 300.0 and good.stop == "target score"


def test_seconds_end_a_search(fixed):
    began = time.monotonic()
    assert modsearch.solve(fixed, "random", seconds=0.2).stop == "seconds"
    assert time.monotonic() - began < 5.0


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        ({"solver": "nope"}, "solver 'nope' is not one of"),
        ({"solver": "ga:size=3"}, "has no option 'size'"),
        ({"solver": 3}, "neither the name of a solver nor a Solver"),
        ({"seed": -1}, "seed: -1 is not in"),
        ({"evaluations": -1}, "a budget must be at least 0"),
        ({"seconds": float("nan")}, "a budget must be at least 0"),
        ({"until": "reached"}, "neither 'achieved' nor a score"),
    ],
)
def test_a_bad_argument_is_a_value_error(fixed, arguments, complaint):
    with pytest.raises(ValueError, match=complaint):
        modsearch.solve(fixed, **arguments)


def test_what_is_no_problem_is_a_type_error_that_says_how_to_make_one():
    with pytest.raises(TypeError, match="'seed/fixed' is no DesignProblem; load_problem makes one"):
        modsearch.solve("seed/fixed")
    with pytest.raises(TypeError, match="is no RobotProblem"):
        modsearch.verify(Mast(), [])


def test_numbers_of_numpy_are_numbers(fixed):
    solution = modsearch.solve(fixed, "random", evaluations=np.int64(20), seed=np.uint64(3), until=np.float32(1e6))
    assert solution.evaluations == 20


def test_a_policy_that_is_missing_is_a_file_error(fixed):
    with pytest.raises(modsearch.FileError, match="nowhere.json"):
        modsearch.solve(fixed, "policy:nowhere.json")


def test_a_problem_of_ones_own_is_searched_to_its_optimum():
    solution = modsearch.solve(Mast(), "ga", evaluations=4000, seed=1)
    assert 3.95 < solution.score <= 4.0 and solution.achieved


def test_what_an_own_problem_raises_counts_as_a_failed_evaluation_and_is_told():
    mast = Mast(faults=[ValueError("too windy"), KeyError("rope")])
    solution = modsearch.solve(mast, "random", evaluations=100)
    assert solution.evaluations == mast.calls == 100
    assert solution.failed == 2 and solution.first_failure == "ValueError: too windy"
    assert solution.outcomes["exception"] == 2
    assert solution.achieved


def test_evaluating_an_own_problem_raises_what_it_raised_in_words():
    with pytest.raises(modsearch.EvaluationError, match="ValueError: too windy"):
        Mast(faults=[ValueError("too windy")]).evaluate([])


def test_a_score_of_nan_is_a_failed_evaluation():
    class Nothing(Mast):
        def do_evaluate(self, design, fidelity):
            return modsearch.Evaluation(float("nan"), achieved=True)

    solution = modsearch.solve(Nothing(), "random", evaluations=10)
    assert solution.failed == 10 and not solution.achieved and solution.score == -np.inf


def test_an_own_problem_that_returns_something_else_says_so():
    class Number(Mast):
        def do_evaluate(self, design, fidelity):
            return 3.0

    with pytest.raises(modsearch.EvaluationError, match="do_evaluate returned 3.0, not an Evaluation"):
        Number().evaluate([])


def test_an_own_problem_may_narrow_down_what_follows():
    class LinksOnly(Mast):
        def do_successors(self, types):
            return ["link"]

    solution = modsearch.solve(LinksOnly(), "random", evaluations=200)
    assert set(solution.design.types) == {"link"}


def test_keyboard_interrupt_in_an_own_problem_ends_the_search():
    with pytest.raises(KeyboardInterrupt):
        Mast(faults=[KeyboardInterrupt()]).evaluate([])

    class Interrupted(Mast):
        def do_evaluate(self, design, fidelity):
            if self.calls == 20:
                raise KeyboardInterrupt
            return super().do_evaluate(design, fidelity)

    solution = modsearch.solve(Interrupted(), "random", evaluations=1000)
    assert solution.stop == "interrupted" and solution.evaluations == 21


def test_system_exit_in_an_own_problem_is_raised():
    with pytest.raises(SystemExit):
        modsearch.solve(Mast(faults=[SystemExit(3)]), "random", evaluations=1000)


def test_a_solver_of_ones_own_gives_what_the_same_one_of_the_library_gives(fixed):
    own = modsearch.solve(fixed, Luck(), evaluations=500, seed=3)
    theirs = modsearch.solve(fixed, "random", evaluations=500, seed=3)
    assert own.design == theirs.design and own.score == theirs.score
    assert own.solver == "luck" and own.reason == "out of luck" and own.evaluations == 500


def test_problems_and_solvers_of_ones_own_survive_pickle():
    mast, luck = pickle.loads(pickle.dumps((Mast(faults=[ValueError("once")]), Luck())))
    assert (mast.name, mast.max_modules, list(mast.context), mast.library.name) == ("mast", 4, [4.0], "seed")
    solution = modsearch.solve(mast, luck, evaluations=50)
    assert solution.failed == 1 and solution.evaluations == mast.calls == 50


def test_a_solver_of_ones_own_may_be_refined(fixed):
    raw = modsearch.solve(fixed, Luck(), evaluations=500, until="achieved")
    refined = modsearch.solve(fixed, Luck(), evaluations=500, until="achieved", refine=True)
    assert refined.score >= raw.score


def test_what_an_own_solver_raises_is_raised_by_solve(fixed):
    class Broken(modsearch.Solver):
        def do_solve(self, problem, meter, rng):
            meter.evaluate(problem, [])
            raise KeyError("oops")

    with pytest.raises(KeyError, match="oops"):
        modsearch.solve(fixed, Broken(), evaluations=10)


def test_a_meter_is_of_no_use_after_its_search(fixed):
    luck = Luck()
    modsearch.solve(fixed, luck, evaluations=5)
    with pytest.raises(RuntimeError, match="this meter's search is over"):
        luck.meter.evaluate(fixed, [])


def test_a_meter_is_of_no_use_in_another_thread(fixed):
    class Crowd(modsearch.Solver):
        def do_solve(self, problem, meter, rng):
            with ThreadPoolExecutor(1) as pool:
                pool.submit(meter.evaluate, problem, []).result()

    with pytest.raises(RuntimeError, match="for the thread that searches"):
        modsearch.solve(fixed, Crowd(), evaluations=5)


def test_a_search_may_be_started_within_a_search(fixed):
    class Nested(modsearch.Solver):
        def do_solve(self, problem, meter, rng):
            inner = modsearch.solve(Mast(), Luck(), evaluations=20)
            assert inner.evaluations == 20
            meter.evaluate(problem, [("link", [0.5])])

    assert modsearch.solve(fixed, Nested(), evaluations=10).evaluations == 1


def test_progress_tells_a_function_how_far_it_is(fixed):
    told = []
    modsearch.solve(fixed, "random", seconds=1.0, progress=told.append)
    assert told and told[-1].evaluations > 0 and told[-1].score is not None


def test_progress_is_told_as_lines_where_there_is_no_terminal(fixed, capfd):
    modsearch.solve(fixed, "random", seconds=0.6, progress=True)
    said = capfd.readouterr().err
    assert said.count("\n") == 1 and "evaluations: best" in said and "\r" not in said


def test_what_a_progress_function_raises_ends_the_search(fixed):
    def progress(_):
        raise ZeroDivisionError("enough")

    with pytest.raises(ZeroDivisionError, match="enough"):
        modsearch.solve(fixed, "random", seconds=60.0, progress=progress)


def test_other_threads_run_during_a_search(fixed):
    ticks = 0
    stop = threading.Event()

    def tick():
        nonlocal ticks
        while not stop.is_set():
            ticks += 1
            time.sleep(0.001)

    thread = threading.Thread(target=tick)
    thread.start()
    before = ticks
    modsearch.solve(fixed, "random", evaluations=20_000)
    after = ticks
    stop.set()
    thread.join()
    assert after > before


def test_threads_that_search_at_once_find_what_one_alone_finds():
    def scores(solver):
        problems = [modsearch.load_problem("seed/random_obstacles", (0, i)) for i in range(4)]
        return [modsearch.solve(problem, solver, evaluations=20).score for problem in problems]

    # Ipopt's linear solver is not made for threads: the library lets them take turns.
    for solver in ("per-sequence:inner=ipopt", "per-sequence:inner=own", "ga"):
        alone = scores(solver)
        with ThreadPoolExecutor(4) as pool:
            for together in pool.map(scores, [solver] * 4):
                assert together == alone


SEARCH = """
import sys, modsearch
class Slow(modsearch.Solver):
    def do_solve(self, problem, meter, rng):
        print("begun", flush=True)
        while meter.evaluate(problem, modsearch.random_design(problem, rng)):
            pass
problem = modsearch.load_problem("seed/fixed")
solver = Slow() if sys.argv[1] == "own" else "random"
if sys.argv[1] != "own":
    print("begun", flush=True)
solution = modsearch.solve(problem, solver, seconds=100.0)
print(solution.stop, solution.evaluations > 0)
"""


@pytest.mark.parametrize("whose", ["own", "theirs"])
def test_ctrl_c_stops_a_search_and_gives_what_there_is(whose):
    with subprocess.Popen([sys.executable, "-c", SEARCH, whose], stdout=subprocess.PIPE, text=True) as child:
        assert child.stdout is not None
        assert child.stdout.readline() == "begun\n"
        time.sleep(0.5)  # within the hundred seconds of the search
        child.send_signal(signal.SIGINT)
        said, _ = child.communicate(timeout=20)
    assert said == "interrupted True\n" and child.returncode == 0


def test_a_solution_survives_pickle_with_its_problem(obstacles):
    solution = modsearch.solve(obstacles)
    again = pickle.loads(pickle.dumps(solution))
    assert again.design == solution.design and again.score == solution.score and again.bound == solution.bound
    assert again.problem.instance == (0, 3)
    assert modsearch.verify(again.problem, again)


def test_a_solution_of_an_own_problem_is_pickled_without_it():
    again = pickle.loads(pickle.dumps(modsearch.solve(Mast(), "random", evaluations=10)))
    assert again.problem is None and again.evaluations == 10


def test_a_solution_is_saved_as_a_file_that_the_command_line_verifies(obstacles, tmp_path):
    file = tmp_path / "solution.json"
    solution = modsearch.solve(obstacles).with_path()
    solution.save(file)
    done = subprocess.run([program("modsearch"), "verify", file], capture_output=True, text=True, check=False)
    assert done.returncode == 0 and done.stdout.startswith("verified: achieved")
    loaded = modsearch.load_solution(file)
    assert loaded.design == solution.design and loaded.score == solution.score
    assert modsearch.verify(loaded.problem, loaded)


def test_a_solution_file_names_its_problem_file_from_where_it_lies(tmp_path):
    problem_file = tmp_path / "problem.json"
    problem_file.write_text(modsearch.convert("seed/fixed", "modsearch", folder=tmp_path))
    problem = modsearch.load_problem(problem_file)
    file = tmp_path / "deeper" / "solution.json"
    file.parent.mkdir()
    modsearch.solve(problem).save(file)
    assert json.loads(file.read_text())["problem"] == "../problem.json"
    assert modsearch.load_solution(file).achieved


def test_verify_finds_a_claim_that_does_not_hold(fixed, lever):
    solution = modsearch.solve(fixed)
    forged = modsearch.Solution(
        design=solution.design, problem=fixed, evaluation=modsearch.Evaluation(999.0, achieved=True)
    )
    verification = modsearch.verify(fixed, forged)
    assert not verification and any("not 999 as claimed" in finding for finding in verification.findings)


def test_a_notebook_shows_a_page_of_its_own(obstacles):
    shown = modsearch.solve(obstacles)._repr_html_()
    assert shown.startswith('<iframe srcdoc="') and shown.count('"') == 4
    assert "seed/random_obstacles" in shown
    assert modsearch.solve(Mast(), "random", evaluations=1)._repr_html_() is None


def test_a_design_that_is_not_achieved_is_shown_with_what_it_misses(obstacles):
    solution = modsearch.solve(obstacles, "random", evaluations=1, seed=1)
    assert not solution and solution.nearest is not None
    assert "outside its tolerance" in solution.to_html()


def test_a_certificate_is_written_and_checked_by_an_independent_program(fixed, tmp_path):
    file = tmp_path / "certificate.json"
    certificate = modsearch.certify(fixed, file)
    assert certificate and certificate.lower <= modsearch.solve(fixed).score + 1e-9 <= certificate.upper + 1e-9
    assert modsearch.check_certificate(file)
    forged = json.loads(file.read_text())
    forged["claim"]["upper"] -= 1.0
    file.write_text(json.dumps(forged))
    check = modsearch.check_certificate(file)
    assert not check and "rejected" in check.words


def test_python_m_modsearch_is_the_command_line():
    def run(*words):
        command = [sys.executable, "-m", "modsearch", *words]
        return subprocess.run(command, capture_output=True, text=True, check=False)

    assert (
        run("list", "problems").stdout
        == subprocess.run(
            [program("modsearch"), "list", "problems"], capture_output=True, text=True, check=False
        ).stdout
    )
    refused = run("solve", "nowhere.json")
    assert refused.returncode == 2 and "nowhere.json" in refused.stderr
