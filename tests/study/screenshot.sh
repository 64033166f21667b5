#!/bin/sh
# screenshot.sh WHAT PROGRAM FOLDER: screenshot.py, or exit 77 with the reason where the machine has not what it needs.
set -eu
for program in chromium python3; do
  if ! command -v "$program" >/dev/null; then
    echo "skipped: no $program"
    exit 77
  fi
done
exec python3 "$(dirname "$0")/screenshot.py" "$@"
