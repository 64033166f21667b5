"""python -m modsearch: the command line, as a child process."""

import signal
import subprocess
import sys

from .program import program


def main() -> int:
    """Runs the program `modsearch` with the arguments of this one; its exit status."""
    child = subprocess.Popen([program("modsearch"), *sys.argv[1:]])

    def pass_on(number: int, _frame: object) -> None:
        child.send_signal(number)

    # The child knows what to do with them. Ctrl-C in a terminal reaches it as well, and once is enough.
    for number in (signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, pass_on)
    signal.signal(signal.SIGINT, signal.SIG_IGN if sys.stdin.isatty() else pass_on)
    status = child.wait()
    return status if status >= 0 else 128 - status


if __name__ == "__main__":
    sys.exit(main())
