"""Says the tasks of LIBERO in this language, runs them, and prints a table of all.

python benchmarks/libero.py ../shared/data/libero --episodes 10 --world kinematic --out said

Objects, facts at the start and goals are those of the originals, one to one. Shapes are boxes, cylinders
and bins of about the right size. What stands on the table stands about where it does there; furniture stands
along the sides.
"""

from __future__ import annotations

import argparse
import re
import sys
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import torch
from sexpressions import flat, parts_of, read_problem, typed
from shares import shares

from ntp_dsl.common.resources import examples_folder

SHAPES = {  # of what is moved, as long as it fits the hand in one direction
    "akita_black_bowl": "cylinder(7 cm, 5 cm)",
    "white_bowl": "cylinder(7 cm, 5 cm)",
    "glazed_rim_porcelain_ramekin": "cylinder(7 cm, 4 cm)",
    "plate": "cylinder(12 cm, 1.5 cm)",
    "cream_cheese": "box(8 cm, 4 cm, 3 cm)",
    "butter": "box(9 cm, 4 cm, 4 cm)",
    "chocolate_pudding": "box(7 cm, 5 cm, 3 cm)",
    "cookies": "box(7 cm, 5 cm, 4 cm)",
    "ketchup": "cylinder(5 cm, 11 cm)",
    "bbq_sauce": "cylinder(5 cm, 11 cm)",
    "salad_dressing": "cylinder(5 cm, 11 cm)",
    "new_salad_dressing": "cylinder(5 cm, 11 cm)",
    "tomato_sauce": "cylinder(6.5 cm, 8 cm)",
    "alphabet_soup": "cylinder(6.5 cm, 8 cm)",
    "milk": "box(6 cm, 6 cm, 11 cm)",
    "orange_juice": "box(6 cm, 6 cm, 11 cm)",
    "wine_bottle": "cylinder(6 cm, 13 cm)",
    "red_coffee_mug": "cylinder(6.5 cm, 7 cm)",
    "porcelain_mug": "cylinder(6.5 cm, 7 cm)",
    "white_yellow_mug": "cylinder(6.5 cm, 7 cm)",
    "moka_pot": "cylinder(6.5 cm, 9 cm)",
    "chefmate_8_frypan": "cylinder(12 cm, 4 cm)",
    "black_book": "box(9 cm, 3 cm, 11 cm)",
    "yellow_book": "box(9 cm, 3 cm, 11 cm)",
}
HOLDERS = {"basket": "bin(22 cm, 22 cm, 8 cm)", "wooden_tray": "bin(18 cm, 18 cm, 3 cm)"}
BODY, COMPARTMENT, PART = "box(11 cm, 11 cm, 12 cm)", "bin(12 cm, 12 cm, 5 cm)", "box(10 cm, 10 cm, 0.5 cm)"
LOW = "box(6 cm, 6 cm, 5 cm)"  # of what the hand gets to: as narrow as it opens
BURNER, BURNERS = (
    "box(10 cm, 10 cm, 2 cm)",
    "box(26 cm, 16 cm, 2 cm)",
)  # beside the knobs, for one pot and for two
SMALL = [(x, side * y) for y in (36, 50) for x in (33, 45) for side in (1, -1)]  # of furniture [cm]
WIDE = [(63, 30), (63, -30)]  # of burners, baskets and trays [cm]
# Where things may stand, and how far beside that place they may start [cm].
NEAR, FAR, SIDE, ROOM = 32, 70, 24, 6
FACTS = {"Open": "open({})", "Turnon": "running({})"}


@dataclass
class Original:
    """A task of the benchmark as its file says it."""

    name: str
    regions: dict[str, tuple[str, tuple[float, ...]]] = field(default_factory=dict)  # target, range [m]
    fixtures: dict[str, str] = field(default_factory=dict)  # name -> category
    objects: dict[str, str] = field(default_factory=dict)
    initially: list[list[str]] = field(default_factory=list)
    goal: list[list[str]] = field(default_factory=list)


def read(path: Path) -> Original:
    """Read a file of the benchmark."""
    parts = parts_of(read_problem(path))
    found = Original(path.stem)
    for row in parts[":regions"]:
        details = {str(each[0]): each[1:] for each in row[1:] if isinstance(each, list)}
        target = str(details[":target"][0])
        numbers = [float(v) for v in flat(details.get(":ranges", []))]
        found.regions[f"{target}_{row[0]}"] = target, tuple(numbers[:4])
    found.fixtures = dict(typed(parts[":fixtures"]))
    found.objects = dict(typed(parts[":objects"]))
    found.initially = [list(map(str, each)) for each in parts[":init"]]
    inside = {f"{name}_contain_region": name for name, kind in found.objects.items() if kind in HOLDERS}
    [goal] = parts[":goal"]
    facts = goal[1:] if goal[0] == "And" else [goal]
    found.goal = [[inside.get(str(each), str(each)) for each in fact] for fact in facts]
    return found


class Saying:
    """One task in the words of `examples/libero/libero.ntp`."""

    def __init__(self, original: Original) -> None:
        self._original = original
        self._small, self._wide = iter(SMALL), iter(WIDE)
        self._groups: dict[str, str] = {}

    def text(self) -> str:
        """Return the declaration of the task. Raises `KeyError` for what there are no words for."""
        original = self._original
        used = {name for fact in (*original.initially, *original.goal) for name in fact[1:]}
        used |= {
            each for fact in original.goal if fact[0] == "In" for each in _doors(fact[2], original.fixtures)
        }
        for name, kind in original.fixtures.items():
            if not _is_surface(kind):
                self._fixture(name, kind, [each for each in used if each.startswith(f"{name}_")])
        for name in sorted(used):
            target, numbers = original.regions.get(name, ("", ()))
            if _is_surface(original.fixtures.get(target, "-")) and name in _goal_names(original):
                x, y = _place(numbers)
                self._groups[name] = f"Region on table with box(8 cm, 8 cm, 0.2 cm), at({x:g} cm, {y:g} cm)"
        starts = {fact[1]: fact[2] for fact in original.initially if fact[0] in ("On", "In")}
        for name, kind in sorted(original.objects.items(), key=lambda each: _depth(each[0], starts)):
            self._object(name, kind, starts[name])
        facts = [FACTS[fact[0]].format(fact[1]) for fact in original.initially if fact[0] in FACTS]
        rows = [
            f"task {_identifier(original.name)}:",
            "    scene:",
            *(f"        {name}: {group}" for name, group in self._groups.items()),
        ]
        if facts:
            rows.append(f"    initially: {', '.join(facts)}")
        run, success = _run(original.goal)
        return "\n".join([*rows, f"    run: {run}", f"    success: {success}", ""])

    def _fixture(self, name: str, kind: str, parts: Sequence[str]) -> None:
        x, y = next(self._small)
        at = f"at({x} cm, {y} cm)"
        if kind == "microwave":
            self._groups[name] = f"Compartment on table with {LOW}, {at}"
        elif kind == "flat_stove":
            self._groups[name] = f"Appliance on table with {LOW}, {at}"
        else:
            self._groups[name] = f"Furniture on table with {BODY}, {at}"
        for part in sorted(parts):
            self._part(part, name, kind)

    def _part(self, name: str, fixture: str, kind: str) -> None:
        """Add a part of a piece of furniture: what things go into stands beside it, the rest is on top."""
        facts = [fact[0] for fact in (*self._original.initially, *self._original.goal) if name in fact[1:]]
        if {"Open", "Close"} & {*facts} or ("cabinet" in kind and "In" in facts):
            x, y = next(self._small)
            self._groups[name] = f"Compartment on table with {COMPARTMENT}, at({x} cm, {y} cm)"
        elif "In" in facts:
            x, y = next(self._small)
            self._groups[name] = f"Holder on table with {COMPARTMENT}, at({x} cm, {y} cm)"
        elif kind == "flat_stove":
            x, y = next(self._wide)
            shape = BURNERS if facts.count("On") > 1 else BURNER
            self._groups[name] = f"Region on table with {shape}, at({x} cm, {y} cm)"
        else:
            self._groups[name] = f"Region on {fixture} with {PART}"

    def _object(self, name: str, kind: str, start: str) -> None:
        target, numbers = self._original.regions.get(start, ("", ()))
        on_table = _is_surface(self._original.fixtures.get(target, self._original.fixtures.get(start, "-")))
        if kind in HOLDERS:
            x, y = next(self._wide)
            self._groups[name] = f"Holder on table with {HOLDERS[kind]}, at({x} cm, {y} cm)"
            return
        where = ""
        if on_table and numbers:
            x, y = _place(numbers)
            where = f", x({x - ROOM:g} .. {x + ROOM:g} cm), y({y - ROOM:g} .. {y + ROOM:g} cm)"
        self._groups[name] = f"Thing on {'table' if on_table else start} with {SHAPES[kind]}{where}"


def _is_surface(kind: str) -> bool:
    return kind == "floor" or kind.endswith("table")


def _doors(region: str, fixtures: dict[str, str]) -> Iterator[str]:
    """Yield what must be open for something to be in a region."""
    yield from (name for name, kind in fixtures.items() if kind == "microwave" and region.startswith(name))


def _goal_names(original: Original) -> set[str]:
    return {name for fact in original.goal for name in fact[1:]}


def _depth(name: str, starts: dict[str, str]) -> int:
    return 1 + _depth(starts[name], starts) if name in starts else 0


def _place(numbers: Sequence[float]) -> tuple[float, float]:
    """Return where the middle of a range is on our table [cm]."""
    x, y = (numbers[0] + numbers[2]) / 2, (numbers[1] + numbers[3]) / 2
    return min(max(NEAR, round(50 + 110 * x, 1)), FAR), min(max(-SIDE, round(100 * y, 1)), SIDE)


def _identifier(name: str) -> str:
    return name.lower()


RUNS = {  # kinds of goals -> what is run
    ("On",): "pick_and_place({0[1]}, {0[2]})",
    ("In",): "put_in({0[1]}, {0[2]})",
    ("Open",): "open_up({0[1]})",
    ("Close",): "shut({0[1]})",
    ("Turnon",): "switch_on({0[1]})",
    ("Turnoff",): "switch_off({0[1]})",
    ("On", "On"): "both_on({0[1]}, {0[2]}, {1[1]}, {1[2]})",
    ("In", "In"): "both_in({0[1]}, {1[1]}, {0[2]})",
    ("Turnon", "On"): "put_on_and_switch_on({1[1]}, {1[2]}, {0[1]})",
    ("On", "Turnon"): "put_on_and_switch_on({0[1]}, {0[2]}, {1[1]})",
    ("On", "On", "Turnon"): "both_on_and_switch_on({0[1]}, {1[1]}, {0[2]}, {1[2]}, {2[1]})",
    ("Open", "In"): "put_away_and_leave_open({1[1]}, {0[1]})",
    ("In", "Close"): "put_away_and_shut({0[1]}, {0[2]})",
    ("Close", "In"): "put_away_and_shut({1[1]}, {1[2]})",
    ("Close", "Open"): "shut_and_open({0[1]}, {1[1]})",
    ("On", "In"): "_stack_in({0[1]}, {0[2]}, {1[2]})",
}
HOLDS = {
    "Close": "not open({1})",
    "Open": "open({1})",
    "Turnon": "running({1})",
    "Turnoff": "not running({1})",
}


def _run(goal: Sequence[Sequence[str]]) -> tuple[str, str]:
    run = RUNS[tuple(fact[0] for fact in goal)].format(*goal)
    if "heating_region" in run and "put_away_and_shut" in run:
        door = next(fact[1] for fact in goal if fact[0] == "Close")
        run = run.replace("put_away_and_shut", "put_inside_and_shut").replace(")", f", {door})")
    if "cabinet" in run and run.startswith("put_in("):
        run = run.replace("put_in(", "put_away(")
    holds = [
        HOLDS[fact[0]].format(*fact) if fact[0] in HOLDS else f"{fact[0].lower()}({fact[1]}, {fact[2]})"
        for fact in goal
    ]
    return run, " and ".join(holds)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("data", type=Path, help="the folder of the benchmark's tasks")
    parser.add_argument(
        "--episodes", type=int, default=10, help="of each task, by the expert and by the core"
    )
    parser.add_argument("--world", default="kinematic", choices=("kinematic", "bullet"))
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--only", default="", help="tasks of which the name matches")
    parser.add_argument("--expert", action="store_true", help="by the expert alone")
    parser.add_argument("--out", type=Path, help="write the tasks as libraries to this folder, and keep them")
    given = parser.parse_args()
    torch.set_num_threads(1)
    head = (examples_folder() / "libero" / "libero.ntp").read_text(encoding="utf-8").partition("\ntask ")[0]
    paths = [each for each in sorted(given.data.glob("*/*.bddl")) if re.search(given.only, each.stem, re.I)]
    if not paths:
        sys.exit(f"{given.data}: expected folders with .bddl files")
    with tempfile.TemporaryDirectory() as temporary:
        folder = given.out or Path(temporary)
        for path in paths:
            print(f"| {path.stem} | {' | '.join(measure(path, head, folder, given))} |", flush=True)


def measure(path: Path, head: str, folder: Path, given: argparse.Namespace) -> Iterator[str]:
    """Yield whether a task is said, and how often the expert and the core do it."""
    try:
        text = Saying(read(path)).text()
    except (KeyError, StopIteration) as error:
        yield f"not said: {error!r}"
        return
    library = folder / _identifier(path.stem) / "libero.ntp"
    library.parent.mkdir(parents=True, exist_ok=True)
    library.write_text(f"{head}\n{text}", encoding="utf-8")
    task = _identifier(path.stem)
    yield from shares(library.parent, task, given.episodes, given.seed, given.world, not given.expert)


if __name__ == "__main__":
    main()
