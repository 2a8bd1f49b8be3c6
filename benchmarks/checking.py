"""How long checks take: an example from the shell, 1,000 programs, and one edit among 1,000 programs.

    python benchmarks/checking.py [--json]

Wall time, and processor time beside it, since another job may share the machine.
"""

from __future__ import annotations

import argparse
import json
import random
import resource
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

from ntp_dsl.common.resources import examples_folder
from ntp_dsl.language.incremental import Session

PROGRAMS = 1_000
RUNS = 7  # of the command
EDITS = 40

HEADER = '''library many
"""A thousand programs, as a workshop would have them."""

use tabletop

constant tray: Place
enum Side: left, right

api push(x: Object, side: Side, way: length in 0 .. 0.3 m)
    """Shove it aside."""
    requires above(gripper, x) and empty(gripper)
'''
KINDS = (
    '''program carry_{i}(item: Object, support: Place):
    """Bring the item onto the support (variant {i})."""
    requires present(item) and reachable(item) and present(support) and reachable(support)
    achieves on(item, support)
    clear(support)
    pick(item)
    place(item, support)
''',
    '''program build_{i}(goal: list[Placement]):
    """Every item on its support, from the bottom up."""
    achieves all on(p.item, p.support) for p in goal
    for p in goal:
        carry_{before}(p.item, p.support)
''',
    '''program unload_{i}(x: Place):
    """Everything that lies there goes to the table."""
    achieves not some on(o, x) for o in Object
    for o in Object if on(o, x):
        pick_and_place(o, table)
''',
    '''program nudge_{i}(x: Object):
    """Free it, then shove it a little."""
    requires present(x) and reachable(x)
    achieves clear(x) and above(gripper, x)
    put_down()
    clear(x)
    move_to(x)
    push(x, left, {size} cm)  # not far
''',
)


def library(programs: int) -> str:
    """Return a library of so many programs with contracts, loops, docstrings and comments."""
    kinds = (KINDS[i % len(KINDS)].format(i=i, before=i - 1, size=i % 30) for i in range(programs))
    return "\n".join([HEADER, *kinds])


def edited(text: str, rng: random.Random) -> str:
    """Return the text with one declaration changed: its body, its contract, a name, or a mistake in it."""
    old, new = rng.choice(
        [
            ("    clear(support)\n", "    put_down()\n    clear(support)\n"),
            ("    requires present(x) and", "    requires clear(x) and present(x) and"),
            ("    clear(x)\n", "    cler(x)\n"),
            ("    pick(item)\n", "    pick(item\n"),
            ("program unload_", "program empty_"),
        ]
    )
    at = text.index(old, rng.randrange(len(text) // 2))
    return text[:at] + new + text[at + len(old) :]


def timed(work: Callable[[], object], whose: int = resource.RUSAGE_SELF) -> tuple[float, float]:
    """Return seconds of wall time and of processor time."""
    before, start = resource.getrusage(whose), time.perf_counter()
    work()
    wall, after = time.perf_counter() - start, resource.getrusage(whose)
    return wall, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def spread(times: list[tuple[float, float]]) -> dict[str, float]:
    walls, cpus = zip(*times, strict=True)
    return {
        "wall_ms": round(1e3 * statistics.median(walls), 1),
        "wall_most_ms": round(1e3 * max(walls), 1),
        "processor_ms": round(1e3 * statistics.median(cpus), 1),
        "runs": len(times),
    }


def shell(path: Path) -> list[tuple[float, float]]:
    command = [sys.executable, "-m", "ntp_dsl", "check", "--static", str(path)]

    def run() -> None:
        subprocess.run(command, check=True, capture_output=True)

    run()  # what Python compiles once
    return [timed(run, resource.RUSAGE_CHILDREN) for _ in range(RUNS)]


def edits(path: Path) -> list[tuple[float, float]]:
    text, session, rng = path.read_text(), Session(), random.Random(0)
    session.diagnose(path)
    times = []
    for _ in range(EDITS):
        times.append(timed(lambda: session.diagnose(path, {path: edited(text, rng)})))
        session.diagnose(path)
    return times


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--json", action="store_true", help="one document for machines")
    as_json = parser.parse_args().json
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "many.ntp"
        path.write_text(library(PROGRAMS))
        figures = {
            "an example, from the shell": spread(shell(examples_folder() / "block_stacking")),
            f"{PROGRAMS} programs, from the shell": spread(shell(path)),
            f"one edit among {PROGRAMS} programs": spread(edits(path)),
        }
    if as_json:
        print(json.dumps(figures))
        return
    for what, found in figures.items():
        print(
            f"{what:32} {found['wall_ms']:8.0f} ms (most {found['wall_most_ms']:.0f}),"
            f" {found['processor_ms']:.0f} ms of the processor, median of {found['runs']}"
        )


if __name__ == "__main__":
    main()
