"""Says problems of PDDL's blocks, gripper, ferry, logistics and child-snack, runs them, and prints a table.

python benchmarks/pddl.py PROBLEMS --episodes 3 --out said

Reads PROBLEMS/blocks/*.pddl, PROBLEMS/gripper/*.pddl and so on. Objects, facts at the start and goals are
those of the problems, one to one; the programs are those of `tests/evaluation/domains`.
"""

from __future__ import annotations

import argparse
import re
import sys
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import torch
from sexpressions import Sexp, parts_of, read_problem, typed
from shares import shares

from ntp_dsl.language.diagnostics.diagnostics import NtpError

LIBRARIES = Path(__file__).parents[1] / "tests" / "evaluation" / "domains"
COLUMNS, PITCH, EDGE = 24, 2.5, 1  # of the grid on which stands what nothing moves [cm]
CORNER = (31, -29)  # of that grid, x and y [cm]

Fact = tuple[str, ...]


@dataclass(frozen=True)
class Domain:
    """How the words of one domain are said: names that are not listed stay as they are."""

    library: str
    run: str
    types: Mapping[str, str]  # type, or predicate of one object -> type; of several the last listed
    facts: Mapping[str, str] = field(default_factory=dict)  # predicate -> fact, `{1}` is the first object
    goal: Mapping[str, str] = field(default_factory=dict)  # predicate -> record
    unsaid: Sequence[str] = ()  # predicates that are always so here

    def fact(self, fact: Fact) -> str:
        """Return a fact in the words of the library."""
        name, *objects = fact
        return self.facts.get(name, f"{name}({', '.join(objects)})").format(*fact)


DELIVERY = {"at": "({1}, {2})"}
BLOCKS = Domain(
    "blocks",
    "rebuild(goal)",
    types={"block": "Block", "object": "Block"},
    facts={
        **dict.fromkeys(("ontable", "on-table"), "on({1}, table)"),
        **dict.fromkeys(("handempty", "emptyhand"), "empty(gripper)"),
    },
    goal={"on": "({1}, {2})", **dict.fromkeys(("ontable", "on-table"), "({1}, table)")},
)
DOMAINS = {
    "blocks": BLOCKS,
    "gripper": Domain(
        "gripper_rooms",
        "bring_all(goal)",
        types={"room": "Room", "ball": "Ball"},
        facts={"at-robby": "here({1})", "carry": "carried({1})"},
        goal=DELIVERY,
        unsaid=("gripper", "free"),
    ),
    "ferry": Domain(
        "ferry",
        "ship_all(goal)",
        types={"car": "Car", "location": "Port"},
        facts={"at-ferry": "docked({1})"},
        goal=DELIVERY,
        unsaid=("empty-ferry", "not-eq", "board", "sail", "debark"),
    ),
    "logistics": Domain(
        "logistics",
        "deliver_all(goal)",
        types={
            "city": "City",
            "location": "Location",
            "airport": "Airport",
            "obj": "Package",
            "truck": "Truck",
            "airplane": "Airplane",
        },
        facts={"in-city": "in_city({1}, {2})"},
        goal=DELIVERY,
    ),
    "child_snack": Domain(
        "child_snack",
        "serve_all(goal)",
        types={
            "child": "Child",
            "place": "Spot",
            "bread-portion": "Bread",
            "content-portion": "Content",
            "sandwich": "Sandwich",
            "tray": "Tray",
        },
        goal={"served": "({1})"},
    ),
}


@dataclass(frozen=True)
class Problem:
    """A problem as its file says it."""

    kinds: Mapping[str, Sequence[str]]  # object -> its type, and the predicates that it alone is in
    initially: Sequence[Fact]
    goal: Sequence[Fact]


def read(path: Path) -> Problem:
    """Read a problem; names become lower case, as PDDL does not tell the cases apart.

    Raises `NtpError` for what is none, and for goals that are not facts joined by `and`.
    """
    try:
        parts = parts_of(read_problem(path))
    except (UnicodeDecodeError, RecursionError) as error:
        raise NtpError(f"{path}: expected a problem of PDDL, which is text: {error}") from error
    for wanted in (":objects", ":init", ":goal"):
        if not parts.get(wanted):
            raise NtpError(f"{path}: expected a problem of PDDL with {wanted}, found none")
    if not all(map(_is_fact, parts[":init"])):
        raise NtpError(f"{path}: expected facts in :init, such as (on a b)")
    initially = [_fact(each) for each in parts[":init"]]
    kinds = {name.lower(): [kind.lower()] for name, kind in typed(parts[":objects"])}
    for fact in initially:
        if len(fact) == 2 and fact[1] in kinds:
            kinds[fact[1]].append(fact[0])
    goal = parts[":goal"][0]
    facts = goal[1:] if goal and str(goal[0]).lower() == "and" else [goal]
    if not all(map(_is_fact, facts)):
        raise NtpError(f"{path}: expected a goal of facts joined by 'and'; other goals are not said here")
    return Problem(kinds, initially, [_fact(each) for each in facts])


def _is_fact(part: Sexp) -> bool:
    return isinstance(part, list) and bool(part) and all(isinstance(word, str) for word in part)


def _fact(words: Sexp) -> Fact:
    return tuple(str(word).lower() for word in words)


def said(name: str, problem: Problem, domain: Domain) -> str:
    """Return the declaration of a problem as a task."""
    facts = [
        domain.fact(fact)
        for fact in problem.initially
        if fact[0] not in domain.unsaid and not (len(fact) == 2 and fact[0] in domain.types)
    ]
    scene = _towers(problem) if domain is BLOCKS else _grid(objects(problem, domain))
    rows = [f"task {name}:", "    scene:", *(f"        {each}" for each in scene)]
    if domain is not BLOCKS:
        rows += ["    initially:", *(f"        {fact}" for fact in facts)]
    goal = [domain.goal[fact[0]].format(*fact) for fact in problem.goal if fact[0] in domain.goal]
    success = [domain.fact(fact) for fact in problem.goal]
    return "\n".join(
        [
            *rows,
            f"    goal: {', '.join(goal)}",
            f"    run: {domain.run}",
            f"    success: {' and '.join(success)}",
            "",
        ]
    )


def objects(problem: Problem, domain: Domain) -> dict[str, str]:
    """Return the objects of the scene with their types: all but the hands and the ferry."""
    types = {
        name: [said for kind, said in domain.types.items() if kind in kinds]
        for name, kinds in problem.kinds.items()
    }
    return {name: found[-1] for name, found in types.items() if found}


def _grid(types: Mapping[str, str]) -> Iterator[str]:
    """Yield the objects, each on a place of its own."""
    for number, (name, kind) in enumerate(types.items()):
        row, column = divmod(number, COLUMNS)
        x, y = CORNER[0] + PITCH * row, CORNER[1] + PITCH * column
        yield f"{name}: {kind} on table with cube({EDGE} cm), at({x:g} cm, {y:g} cm)"


def _towers(problem: Problem) -> Iterator[str]:
    """Yield the blocks, each after what it stands on."""
    below = {fact[1]: fact[2] for fact in problem.initially if fact[0] == "on"}
    for name in sorted(objects(problem, BLOCKS), key=lambda each: _height(each, below)):
        yield f"{name}: Block on {below.get(name, 'table')}"


def _height(name: str, below: Mapping[str, str]) -> int:
    height = 0
    while name in below and height <= len(below):
        name, height = below[name], height + 1
    return height


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("problems", type=Path, help="a folder with one folder of problems for each domain")
    parser.add_argument("--episodes", type=int, default=3, help="of each, by the expert and by the core")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--only", default="", help="problems of which DOMAIN/FILE matches")
    parser.add_argument("--expert", action="store_true", help="by the expert alone")
    parser.add_argument(
        "--out", type=Path, help="write the problems as libraries to this folder, and keep them"
    )
    given = parser.parse_args()
    torch.set_num_threads(1)
    paths = [
        path
        for name in DOMAINS
        for path in sorted((given.problems / name).glob("*.pddl"))
        if path.stem != "domain" and re.search(given.only, f"{name}/{path.stem}")
    ]
    if not paths:
        sys.exit(f"{given.problems}: expected folders with .pddl files, called {', '.join(DOMAINS)}")
    print("| problem | objects | expert | core |\n|---|---|---|---|")
    with tempfile.TemporaryDirectory() as temporary:
        for path in paths:
            row = " | ".join(measure(path, given.out or Path(temporary), given))
            print(f"| `{path.parent.name}/{path.stem}` | {row} |", flush=True)


def measure(path: Path, folder: Path, given: argparse.Namespace) -> Iterator[str]:
    """Yield how many objects a problem has, and how often the expert and the core do it."""
    domain = DOMAINS[path.parent.name]
    try:
        problem = read(path)
    except NtpError as error:
        yield f"cannot be read: {error}"
        return
    yield str(len(objects(problem, domain)))
    task = f"problem_{re.sub(r'[^a-z0-9]', '_', path.stem.lower())}"
    library = folder / path.parent.name / task / f"{domain.library}.ntp"
    library.parent.mkdir(parents=True, exist_ok=True)
    source = (LIBRARIES / domain.library / library.name).read_text(encoding="utf-8")
    head = source.partition("\ntask ")[0]
    library.write_text(f"{head}\n{said(task, problem, domain)}", encoding="utf-8")
    yield from shares(library.parent, task, given.episodes, given.seed, core=not given.expert)


if __name__ == "__main__":
    main()
