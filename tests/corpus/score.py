"""Print how much of the flawed corpus is caught, located and fixed, rightly or wrongly: `make score`."""

from __future__ import annotations

import sys
from pathlib import Path
from tempfile import TemporaryDirectory

from flawed_libraries import Result, corpus, judge
from rich.console import Console
from rich.table import Table


def main() -> int:
    rows: dict[str, list[Result]] = {}
    files = 0
    with TemporaryDirectory() as folder:
        for flawed in corpus():
            files += 1
            result = judge(flawed, Path(folder))
            rows.setdefault(flawed.path.parent.name, []).append(result)
            for score in result.scores:
                if score.why:
                    print(f"{flawed.name}: {score.why}", file=sys.stderr)
    every = [result for kind in rows.values() for result in kind]
    table = Table("kind", "mistakes", "caught", "located", "fixed", "fixed wrongly")
    for kind, results in [*rows.items(), (f"all of {files} libraries", every)]:
        scores = [score for result in results for score in result.scores]
        counts = [sum(getattr(each, what) for each in scores) for what in ("caught", "located", "fixed")]
        shares = [f"{count / len(scores):.0%}" for count in counts]
        wrong = sum(len(result.wrong) for result in results)
        table.add_row(kind, str(len(scores)), *shares, str(wrong))
    Console(file=sys.stdout).print(table)
    is_good = all(score.caught and score.located for result in every for score in result.scores)
    return int(not is_good or any(result.wrong for result in every))


if __name__ == "__main__":
    sys.exit(main())
