#!/usr/bin/env bash
# Installs what is missing, builds the command line and compares solvers on the built-in study `quick`: a trained agent,
# random search, evolution, Ipopt and what is certified, in one table; and on one task as laboratories have them (`real`):
# three poses, real modules, boxes. Then the reference problem seed/fixed with its best design verified by a collision-free
# path, and pages to look at. May be run again at any time.
set -euo pipefail
# shellcheck source=setup
source "$(dirname "$0")/setup"

(($# == 0)) || { say "usage: ./demo.sh (without arguments; what it does stands at the top of it)"; exit 2; }

study=quick
problem=seed/fixed
answers=$build/demo

install_packages "${product_packages[@]}"
# The tests are part of the build only where their packages are there; they are not compiled here.
tests=OFF
[[ -z $(missing_packages "${test_packages[@]}") ]] && tests=ON
configure -DMODSEARCH_BUILD_TESTS=$tests
compile modsearch modsearch_rl modsearch-check  # all that `cmake --install build` and `check-certificate` need
modsearch=$build/bin/modsearch
export OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1
export LC_ALL=C  # a decimal point whatever the language

rm -rf "$answers"
mkdir -p "$answers"
say "Comparing solvers and an agent, under two minutes on two cores ..."
"$modsearch" compare "$study" --jobs "$cores" --out "$answers/$study"
printf '\nA real task: three full poses among three boxes, drives that must hold the arm, a verified path; 8 s for each solver:\n'
"$modsearch" compare real --jobs "$cores" --out "$answers/real"

printf '\nThe reference problem %s, and every segment of its path checked ten times finer than the planner did:\n' "$problem"
"$modsearch" solve "$problem" --fidelity path --quiet --out "$answers"
"$modsearch" verify "$answers/solution.json" || die "The best design could not be verified."
printf '\nIn any browser:\n  the comparison, with its figures:              %s\n  the real task, with each arm and its motion:   %s\n  the robot, its path and its score in 3-D:      %s\n' \
  "$answers/$study/report.html" "$answers/real/report.html" "$answers/view.html"

cat <<'EOF'

The same in Python, after `pip install .` (docs/python.md):
  problem = modsearch.load_problem("seed/fixed")
  solution = modsearch.solve(problem)
  modsearch.verify(problem, solution)
EOF
