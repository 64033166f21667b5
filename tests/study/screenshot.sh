#!/bin/sh
# screenshot.sh WHAT PROGRAM FOLDER: screenshot.py, or report_screenshot.py for the report of a study; exit 77 with the
# reason where the machine has not what they need.
set -eu
for program in chromium python3; do
  if ! command -v "$program" >/dev/null; then
    echo "skipped: no $program"
    exit 77
  fi
done
script=screenshot.py
if [ "$1" = report ]; then script=report_screenshot.py; fi
exec python3 "$(dirname "$0")/$script" "$@"
