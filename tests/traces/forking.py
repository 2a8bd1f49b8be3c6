"""Runs commands in forks of a process that has all modules loaded, so that starting them is cheap.

Reads commands from standard input, one per line; prints for each its process id, then its exit status.
"""

from __future__ import annotations

import os
import shlex
import sys

import ntp_dsl.core.per_library.policy
import ntp_dsl.datasets.dataset
import ntp_dsl.evaluation.episodes
import ntp_dsl.worlds.arm  # noqa: F401
from ntp_dsl.cli.app import run


def main() -> None:
    for line in sys.stdin:
        child = os.fork()
        if child == 0:
            silent = os.open(os.devnull, os.O_WRONLY)
            os.dup2(silent, 1)
            os.dup2(silent, 2)
            os._exit(run(shlex.split(line)))
        print(child, flush=True)
        _, status = os.waitpid(child, 0)
        print(os.waitstatus_to_exitcode(status), flush=True)


if __name__ == "__main__":
    main()
