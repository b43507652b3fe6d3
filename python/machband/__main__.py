"""The command `machband`, also as ``python -m machband``."""

import signal
import sys

from . import _machband


def main() -> None:
    """Run the program with the arguments of the process."""
    # The program handles signals itself. Python's handler would only note them.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    sys.exit(_machband.main(["machband", *sys.argv[1:]]))


if __name__ == "__main__":
    main()
