#!/usr/bin/env bash
# Installs what is missing, builds everything and runs the tests. May be run again at any time: only what is left to do
# is done.
usage='usage: ./test.sh [--slow] [--sanitize[=thread]] [options of ctest]
  --slow              runs the tests labelled slow too
  --sanitize          in a build of its own, which stops at the first use of memory that is not its own and at undefined
                      behaviour (clang, an hour to build on two cores)
  --sanitize=thread   the tests of what threads share, in a build that stops at the first race
Example: ./test.sh -R Chain        only the tests whose name contains "Chain"
CI=true in the environment turns compiler warnings into errors.'
set -euo pipefail
# shellcheck source=setup
source "$(dirname "$0")/setup"

selection=(-LE slow)
sanitizer=
while (($#)); do
  case $1 in
    --slow) selection=(); shift ;;
    --sanitize) sanitizer=address; shift ;;
    --sanitize=*) sanitizer=${1#*=}; shift ;;
    -h | --help) echo "$usage"; exit ;;
    *) break ;;
  esac
done

install_packages "${product_packages[@]}" "${test_packages[@]}"
warnings_as_errors=OFF
[[ ${CI:-} == true ]] && warnings_as_errors=ON
case $sanitizer in
  "")
    python=(-DMODSEARCH_BUILD_PYTHON=OFF)
    python_environment && python=(-DMODSEARCH_BUILD_PYTHON=ON -DPython_EXECUTABLE="$build/venv/bin/python")
    configure -DMODSEARCH_BUILD_TESTS=ON -DMODSEARCH_BUILD_EXAMPLES=ON \
      -DMODSEARCH_WARNINGS_AS_ERRORS=$warnings_as_errors "${python[@]}"
    compile all
    ;;
  thread)
    sanitize thread
    install_packages "${sanitizer_packages[@]}"
    configure "${sanitize_options[@]}"
    compile modsearch_threads_test
    selection+=(-L '^threads$')
    ;;
  *)
    sanitize "$sanitizer"
    install_packages "${sanitizer_packages[@]}"
    configure "${sanitize_options[@]}"
    compile all
    # Left out: the consumer of the installed package, which is not instrumented and so cannot be linked with libraries
    # that are; the browser, which is not ours; and what looks at the sources alone.
    selection+=(-E '^(InstalledPackage|PageInABrowser|Sources)\.')
    ;;
esac

# Threads of a BLAS would change the order of sums, and with it the last digits, and the times.
export OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1
report=$build/tests.xml
rm -f "$report"
status=0
ctest --test-dir "$build" -j "$cores" --output-on-failure --no-tests=error --output-junit "$report" \
  "${selection[@]}" "$@" || status=$?
[[ -s $report ]] || die "ctest ended with status $status and no report."

if [[ ${selection[*]} == *'-LE slow'* ]]; then
  slow=$(ctest --test-dir "$build" -N -L slow "$@" | awk '/^Total Tests:/ {print $3}')
  ((slow == 0)) || printf '\nLeft out: %d slow tests (./test.sh --slow runs them).\n' "$slow"
fi

# Why tests were skipped, and how all of them went. The report has one element per line; a skipped test has said why
# between GoogleTest's lines "file:line: Skipped" and "[  SKIPPED ]", or, where it is a script, behind "skipped: ".
awk '
  function attribute(name,   text) {
    text = $0
    if (!sub(".*[ \t]" name "=\"", "", text)) return ""
    sub("\".*", "", text)
    return text
  }
  function plain(text) {
    gsub("&lt;", "<", text); gsub("&gt;", ">", text); gsub("&quot;", "\"", text); gsub("&amp;", "\\&", text)
    return text
  }
  /^[ \t]*<testcase / {
    name = plain(attribute("name")); status = attribute("status"); reason = ""; listening = 0
  }
  /^[ \t]*<skipped / && status == "notrun" {
    # ctest also says "skipped" of a test that it could not start.
    if (attribute("message") ~ /^SKIP_/) status = "skipped"
  }
  /: Skipped$/ { listening = 1; next }
  /^([ \t]*<system-out>)?skipped: / { reason = plain($0); sub(".*skipped: ", "", reason); sub("</system-out>$", "", reason) }
  index($0, "[  SKIPPED ]") { listening = 0 }
  listening && $0 != "" { reason = reason (reason == "" ? "" : " ") plain($0) }
  /^[ \t]*<\/testcase>/ {
    if (status == "run") passed++
    else if (status == "skipped" || status == "disabled") {
      skipped++
      if (status == "disabled") reason = "disabled in the source"
      if (reason == "") reason = "no reason given"
      if (!(reason in names)) order[++reasons] = reason
      count[reason]++
      names[reason] = names[reason] "\n      " name
    } else failed++
  }
  END {
    if (skipped) printf "\nSkipped: %d\n", skipped
    for (i = 1; i <= reasons; i++) printf "  %d because: %s%s\n", count[order[i]], order[i], names[order[i]]
    printf "\n%d passed, %d failed, %d skipped\n", passed, failed, skipped
    exit failed > 0
  }' "$report" || status=1
exit "$status"
