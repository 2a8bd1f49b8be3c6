"""The process of a command line: `ntp`, which is `python -m ntp_dsl`."""

import sys


def main() -> None:
    """Run the command line of this process; the entry point of `ntp`."""
    try:
        from ntp_dsl.cli.process import run_process  # here, so that Ctrl-C meanwhile is no traceback

        status = run_process(sys.argv[1:])
    except KeyboardInterrupt:
        print("interrupted", file=sys.stderr)
        status = 130
    sys.exit(status)


if __name__ == "__main__":
    main()
