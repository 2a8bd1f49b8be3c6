"""Print how much of the flawed corpus is caught, located and fixed: `make score`."""

from __future__ import annotations

import sys
from pathlib import Path
from tempfile import TemporaryDirectory

from flawed_libraries import Score, corpus, scores
from rich.console import Console
from rich.table import Table


def main() -> int:
    rows: dict[str, list[Score]] = {}
    files = 0
    with TemporaryDirectory() as folder:
        for flawed in corpus():
            files += 1
            found = scores(flawed, Path(folder))
            rows.setdefault(flawed.path.parent.name, []).extend(found)
            for score in found:
                if score.why:
                    print(f"{flawed.name}: {score.why}", file=sys.stderr)
    every = [score for kind in rows.values() for score in kind]
    table = Table("kind", "mistakes", "caught", "located", "fixed")
    for kind, found in [*rows.items(), (f"all of {files} libraries", every)]:
        counts = [sum(getattr(each, what) for each in found) for what in ("caught", "located", "fixed")]
        shares = [f"{count / len(found):.0%}" for count in counts]
        table.add_row(kind, str(len(found)), *shares)
    Console(file=sys.stdout).print(table)
    return int(not all(score.caught and score.located for score in every))


if __name__ == "__main__":
    sys.exit(main())
