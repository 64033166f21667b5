"""python -m modsearch: the command line, as a child process."""

import signal
import subprocess
import sys

from .program import program


def main() -> int:
    """Runs the program `modsearch` with the arguments of this one; its exit status."""
    child = subprocess.Popen([program("modsearch"), *sys.argv[1:]])
    # Ctrl-C reaches the child as well, which knows what to do with it.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    status = child.wait()
    return status if status >= 0 else 128 - status


if __name__ == "__main__":
    sys.exit(main())
