"""The command ``bt-manip``, also as ``python -m bt_manip``."""

import sys


def main() -> None:
    """Run the command line and leave with its exit code."""
    from bt_manip.cli.exit_codes import BAD_INPUT, INTERRUPTED

    if not (3, 11) <= sys.version_info[:2] <= (3, 14):
        found = ".".join(str(part) for part in sys.version_info[:3])
        print(f"bt-manip needs Python 3.11 to 3.14, this is {found}", file=sys.stderr)
        sys.exit(BAD_INPUT)
    try:
        # Importing takes a while, so whoever presses Ctrl-C during it is heard too.
        from bt_manip.cli.interrupt import Interrupt

        interrupt = Interrupt()
        interrupt.install()
    except KeyboardInterrupt:
        sys.exit(INTERRUPTED)
    from bt_manip.cli.app import run_app
    from bt_manip.cli.streams import open_closed_streams

    open_closed_streams()
    code = run_app(interrupt)
    interrupt.close()
    sys.exit(interrupt.exit_code or code)


if __name__ == "__main__":
    main()
