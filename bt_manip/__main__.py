"""The command ``bt-manip``, also as ``python -m bt_manip``."""

import sys

from bt_manip.cli.interrupt import INTERRUPTED, Interrupt


def main() -> None:
    """Run the command line and leave with its exit code."""
    interrupt = Interrupt()
    interrupt.install()
    try:
        # Importing takes a while, so whoever presses Ctrl-C during it is heard too.
        from bt_manip.cli.app import run_app

        code = run_app(interrupt)
    except KeyboardInterrupt:
        code = INTERRUPTED
    interrupt.close()
    sys.exit(interrupt.exit_code or code)


if __name__ == "__main__":
    main()
