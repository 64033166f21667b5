#!/usr/bin/env bash
# Installs what is missing, builds the command line and solves the reference problem seed/fixed with several solvers side
# by side: a table, the best design verified by a collision-free path, and a page to look at. May be run again at any time.
set -euo pipefail
# shellcheck source=setup
source "$(dirname "$0")/setup"

(($# == 0)) || { say "usage: ./demo.sh (without arguments; what it does stands at the top of it)"; exit 2; }

problem=seed/fixed
solvers=(random per-sequence:inner=ipopt per-sequence:inner=slsqp per-sequence:inner=ceres per-sequence:inner=own auto)
answers=$build/demo

install_packages "${product_packages[@]}" "${demo_packages[@]}"
# The tests are part of the build only where their packages are there; they are not compiled here.
tests=OFF
[[ -z $(missing_packages "${test_packages[@]}") ]] && tests=ON
configure -DMODSEARCH_BUILD_TESTS=$tests
compile modsearch modsearch_rl  # with the last floor, so that `cmake --install build` finds everything
modsearch=$build/bin/modsearch
export OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1
export LC_ALL=C  # a decimal point whatever the language

# Status 1 is an answer too: no achieving design found, or not verified.
answer() {
  local status=0
  "$@" || status=$?
  ((status <= 1)) || die "$* ended with status $status."
}

folder() { printf '%s/%s' "$answers" "$(tr -c 'a-z0-9\n' - <<<"$1")"; }

rm -rf "$answers"
mkdir -p "$answers"
rows=$answers/rows.json
for solver in "${solvers[@]}"; do
  say "Solving $problem with $solver ..."
  options=()
  # Random search proves nothing and would use all the time it is given.
  [[ $solver == random ]] && options=(--evaluations 10000)
  answer "$modsearch" solve "$problem" --solver "$solver" --seed 0 --fidelity path "${options[@]}" --json \
    --out "$(folder "$solver")" >"$answers/answer.json"
  jq --arg asked "$solver" '. + {asked: $asked}' "$answers/answer.json" >>"$rows" || die "$solver gave no JSON."
done

# Achieving designs first, then by score, as everywhere in modsearch; scores equal to six digits by time.
ranked=$(jq -s 'sort_by([(.achieved | not), -((.score // -1e9) * 1e6 | round), .seconds])' "$rows")
printf '\n%-30s %9s %8s %9s %9s %9s %12s %9s %9s\n' \
  solver score modules 'mass [kg]' achieved verified evaluations seconds regret
jq -r 'def yes: if . then "yes" else "no" end;
       (map(select(.achieved).score) | max) as $best
       | .[] | [.asked, .score // "nan", .modules, .mass_kg // "nan", (.achieved | yes), (.verified | yes),
                .evaluations, .seconds, if .achieved then $best - .score else "nan" end] | @tsv' <<<"$ranked" |
  while IFS=$'\t' read -r solver score modules mass achieved verified evaluations seconds regret; do
    printf '%-30s %9.3f %8d %9.3f %9s %9s %12d %9.3f %9.3f\n' "$solver" "$score" "$modules" "$mass" "$achieved" \
      "$verified" "$evaluations" "$seconds" "$regret"
  done

best=$(folder "$(jq -r '.[0].asked' <<<"$ranked")")
printf '\nVerifying the best design: every segment of its path, ten times finer than the planner did.\n'
"$modsearch" verify "$best/solution.json" || die "The best design could not be verified."
cp "$best/view.html" "$answers/view.html"
printf '\nThe robot, its path and its score in 3-D, in any browser: %s\n' "$answers/view.html"
