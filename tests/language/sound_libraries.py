"""Random libraries that are sound by construction: the checker may report nothing about them."""

from __future__ import annotations

import random
from dataclasses import dataclass, field

GIVEN = "present({0}) and reachable({0})"


@dataclass(frozen=True)
class Fact:
    """A predicate about an object (and a member of an enumeration), and the program that achieves it."""

    predicate: str
    program: str
    type: str
    enum: str = ""


@dataclass
class Author:
    """Writes declarations, each with all that it uses."""

    rng: random.Random
    parts: list[str] = field(default_factory=list)
    types: list[str] = field(default_factory=list)
    enums: dict[str, list[str]] = field(default_factory=dict)
    count: int = 0

    def name(self, stem: str) -> str:
        self.count += 1
        return f"{stem}_{self.count}"

    def chance(self, share: float = 0.5) -> bool:
        return self.rng.random() < share

    def write(self, *rows: str) -> None:
        rows = tuple(row for row in rows if row)
        if self.chance(0.3):
            rows = (rows[0] + "  # a remark", *rows[1:])
        if self.chance(0.2):
            rows = ("# A remark.", *rows)
        self.parts.append("\n".join(rows))

    def said(self) -> str:
        return f'    """{self.rng.choice(["What it says.", "It is what it is: (so, so]."])}"""'

    def type(self) -> str:
        if self.types and self.chance(0.6):
            return self.rng.choice(self.types)
        name = self.name("Thing")
        self.write(f"type {name} is {self.rng.choice(['Movable', 'Block', *self.types])}",
                   self.said() if self.chance() else "")  # fmt: skip
        self.types.append(name)
        return name

    def enum(self) -> str:
        if self.enums and self.chance():
            return self.rng.choice(list(self.enums))
        name = self.name("Kind")
        self.enums[name] = [self.name("member") for _ in range(self.rng.randint(2, 4))]
        self.write(f"enum {name}: {', '.join(self.enums[name])}")
        return name

    def fact(self, type: str, depth: int = 2) -> Fact:
        """Write a fact that an api changes, perhaps after another one; or two facts joined."""
        if depth and self.chance(0.25):
            return self.joined(type, depth - 1)
        enum = self.enum() if self.chance(0.3) else ""
        predicate, api, program = (self.name(stem) for stem in ("is", "do", "make"))
        more, given = (f", k: {enum}", ", k") if enum else ("", "")
        before = self.fact(type, depth - 1) if depth and self.chance() else None
        needed, calls = GIVEN.format("x"), []
        if before is not None:
            member = f", {self.rng.choice(self.enums[before.enum])}" if before.enum else ""
            needed += f" and {before.predicate}(x{member})"
            calls.append(f"    {before.program}(x{member})")
        way = self.chance(0.3)
        self.write(f"predicate {predicate}(x: {type}{more})")
        self.write(
            f"api {api}(x: {type}{more}{', way: length in 0 .. 0.3 m' if way else ''})",
            self.said() if self.chance() else "",
            f"    requires {needed}",
            f"    achieves {predicate}(x{given})",
        )
        last = f"{api}(x{given}{', 5 cm' if way else ''})"
        if self.chance(0.2):
            reading = self.name("reads")
            self.write(f"predicate {reading}(x: {type}) -> length")
            last = f"when {reading}(x) > 2 cm: {last}"
        self.write(
            f"program {program}(x: {type}{more}):",
            self.said() if self.chance() else "",
            f"    requires {GIVEN.format('x')}",
            f"    achieves {predicate}(x{given})",
            *calls,
            f"    {last}",
        )
        return Fact(predicate, program, type, enum)

    def joined(self, type: str, depth: int) -> Fact:
        facts = [self.fact(type, depth) for _ in range(2)]
        members = [f", {self.rng.choice(self.enums[each.enum])}" if each.enum else "" for each in facts]
        predicate, program = self.name("is"), self.name("make")
        pairs = list(zip(facts, members, strict=True))
        body = " and ".join(f"{each.predicate}(x{member})" for each, member in pairs)
        self.write(f"predicate {predicate}(x: {type}): {body}")
        self.write(
            f"program {program}(x: {type}):",
            f"    requires {GIVEN.format('x')}",
            f"    achieves {predicate}(x)",
            *(f"    {each.program}(x{member})" for each, member in pairs),
        )
        return Fact(predicate, program, type)

    def loop(self, fact: Fact) -> None:
        """Write a program over the objects of the scene."""
        member = f", {self.rng.choice(self.enums[fact.enum])}" if fact.enum else ""
        self.write(
            f"program {self.name('all')}():",
            f"    achieves all {fact.predicate}(o{member}) for o in {fact.type}",
            f"    for o in {fact.type}:",
            f"        {fact.program}(o{member})",
        )

    def record(self, fact: Fact) -> None:
        """Write a program over a list."""
        record = self.name("Wish")
        kind = f", k: {fact.enum}" if fact.enum else ""
        given = ", w.k" if fact.enum else ""
        self.write(f"record {record}(x: {fact.type}{kind})")
        self.write(
            f"program {self.name('grant')}(goal: list[{record}]):",
            f"    achieves all {fact.predicate}(w.x{given}) for w in goal",
            f"    for w in goal: {fact.program}(w.x{given})",
        )

    def task(self, type: str) -> None:
        """Write a task whose program stacks each element of its goal."""
        stack = self.name("stack")
        promise = "all on(p.item, p.support) for p in goal"
        self.write(
            f"program {stack}(goal: list[Placement]):",
            f"    achieves {promise}",
            "    for p in goal:",
            "        pick_and_place(p.item, p.support)",
        )
        most = self.rng.randint(1, 4)
        self.write(
            f"task {self.name('task')}:",
            self.said() if self.chance() else "",
            f"    scene:   things: {self.rng.randint(6, 9)} {type} on table",
            f"    goal:    towers(things, placements=1..{most}, height=2..3)",
            f"    run:     {stack}(goal)",
            f"    success: {promise}",
        )


def sound_library(rng: random.Random) -> str:
    """Return a library that uses `tabletop`; one with a task declares only what the task reaches."""
    author = Author(rng)
    if author.chance(0.3):
        author.task(author.type())
        author.types.clear()
    else:
        for _ in range(rng.randint(1, 3)):
            fact = author.fact(author.type())
            if author.chance():
                author.loop(fact)
            if author.chance():
                author.record(fact)
    gap = "\n" * rng.randint(1, 3)
    if rng.random() < 0.3:  # what is declared may stand below what speaks of it
        rng.shuffle(author.parts)
    return f'library sound\n"""A library."""\n\nuse tabletop\n{gap}{gap.join(author.parts)}\n'
