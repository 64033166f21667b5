"""A first design: by hand, by a solver, verified by a path, and as a page to look at.

Run: python first_design.py [folder for the page and the solution file]
"""

import pathlib
import sys

import numpy as np

import modsearch

folder = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else ".")

# 1. A problem: reach a target among two spheres and a box, with modules of the built-in library `seed`.
problem = modsearch.load_problem("seed/random_obstacles", instance=(0, 3))
print(problem, problem.goals)

# 2. A design by hand: (type, parameters) for each module. The base is always there.
by_hand = [("hinge", [0.6, 1.4723])]
print("by hand:", modsearch.evaluate(problem, by_hand))

# 3. A solver finds the lengths, and says what is proved.
solution = modsearch.solve(problem)
print(solution)
print(solution.bound)

# 4. From scratch: score, collisions, and a path from home to the goal, looked at ten times finer than it was planned.
print(modsearch.verify(problem, solution))

# 5. The arm as arrays: where its tip is at the goal, and along a straight line through joint space to it.
arm = problem.arm(solution.design)
q = np.linspace(arm.home, solution.postures[0], 5)
print("heights of the tip [m]:", arm.forward(q)[:, 2, 3].round(3))
print("clearance [m]:         ", arm.clearance(q).round(3))

# 6. To keep and to look at.
solution = solution.with_path()
solution.save(folder / "solution.json")
(folder / "view.html").write_text(solution.to_html())
