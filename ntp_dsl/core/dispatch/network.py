"""The dispatch network (f_CN): from rows to the next call, or the end of the program.

Messages run along the edges of a row: between facts and the calls that provide or require them, and between
two calls of which one provides what the other requires; the longer the sequences of such calls are, the more
often. A query is held against a key for each call; the
first call, in the order of the body, whose key answers it, is made; if none does, the program ends.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import torch
from torch import Tensor, nn

from ntp_dsl.core.dispatch.rows import Row

WIDTH = 32
ROUNDS = 4
CALL_FEATURES, FACT_FEATURES, RELATIONS = 4, 4, 4
PROVIDED_BEFORE = 1  # the relation of a call to an earlier one that provides what it requires
MOST_ROUNDS = 24  # for the longest sequences
LEAST = -30.0  # of a logarithm of a probability

Link = tuple[int, int, int, int]  # the call that is told, the fact, the other call, the relation


@dataclass(frozen=True)
class Rows:
    """Many rows as one graph."""

    calls: Tensor  # (calls, CALL_FEATURES)
    facts: Tensor  # (facts, FACT_FEATURES)
    row_of_call: Tensor  # (calls,)
    row_of_fact: Tensor  # (facts,)
    provides: Tensor  # (2, edges) call, fact
    requires: Tensor  # (2, edges) call, fact
    links: Tensor  # (3, links) the call that is told, the fact, the other call
    relations: Tensor  # (links, RELATIONS) one-hot: which of the two provides, and which comes first
    places: Tensor  # (calls,) of each call in its row
    depths: Tensor  # (rows,) of each row, see `_depth`
    count: int  # rows
    longest: int  # calls of a row


def batched(rows: Sequence[Row]) -> Rows:
    calls: list[list[float]] = []
    facts: list[list[float]] = []
    row_of_call: list[int] = []
    row_of_fact: list[int] = []
    places: list[int] = []
    provides: list[tuple[int, int]] = []
    requires: list[tuple[int, int]] = []
    links: list[tuple[int, int, int]] = []
    relations: list[int] = []
    depths: list[int] = []
    for number, row in enumerate(rows):
        first_call, first_fact = len(calls), len(facts)
        last = max(row.statements, default=0)
        for place, (statement, guard) in enumerate(zip(row.statements, row.guards, strict=True)):
            is_first = place == 0 or row.statements[place - 1] != statement
            calls.append(
                [float(guard), (statement + 1) / (last + 1), float(statement == last), float(is_first)]
            )
            places.append(place)
        achieved, required = set(row.achieved), set(row.required)
        for at, probability in enumerate(row.probabilities):
            p = float(probability)
            facts.append([p, float(p > 0.5), float(at in achieved), float(at in required)])
        row_of_call += [number] * len(row.calls)
        row_of_fact += [number] * len(row.facts)
        provides += [(call + first_call, fact + first_fact) for call, fact in row.provides]
        requires += [(call + first_call, fact + first_fact) for call, fact in row.requires]
        found = _links(row)
        depths.append(_depth(row, found))
        for told, fact, other, relation in found:
            links.append((told + first_call, fact + first_fact, other + first_call))
            relations.append(relation)
    return Rows(
        torch.tensor(calls, dtype=torch.float32).reshape(-1, CALL_FEATURES),
        torch.tensor(facts, dtype=torch.float32).reshape(-1, FACT_FEATURES),
        torch.tensor(row_of_call, dtype=torch.long),
        torch.tensor(row_of_fact, dtype=torch.long),
        torch.tensor(provides, dtype=torch.long).reshape(-1, 2).T,
        torch.tensor(requires, dtype=torch.long).reshape(-1, 2).T,
        torch.tensor(links, dtype=torch.long).reshape(-1, 3).T,
        nn.functional.one_hot(torch.tensor(relations, dtype=torch.long), RELATIONS).float()
        if relations
        else torch.zeros(0, RELATIONS),
        torch.tensor(places, dtype=torch.long),
        torch.tensor(depths, dtype=torch.long),
        len(rows),
        max((len(row.calls) for row in rows), default=0),
    )


def _depth(row: Row, links: Sequence[Link]) -> int:
    """Return how many calls follow from one another at most: each provides what a later one requires."""
    before: dict[int, list[int]] = {}
    for told, _, other, relation in links:
        if relation == PROVIDED_BEFORE:
            before.setdefault(told, []).append(other)
    depths: list[int] = []  # of each call; a provider comes earlier
    for call in range(len(row.calls)):
        depths.append(1 + max((depths[other] for other in before.get(call, ())), default=0))
    return max(depths, default=0)


def _links(row: Row) -> list[Link]:
    """Return both ends of each link: a call provides what one of another statement requires."""
    providers: dict[int, list[int]] = {}
    for call, fact in row.provides:
        providers.setdefault(fact, []).append(call)
    found = []
    for call, fact in row.requires:
        for other in providers.get(fact, ()):
            before = row.statements[other] < row.statements[call]
            if row.statements[other] != row.statements[call]:
                found.append((call, fact, other, int(before)))
                found.append((other, fact, call, 2 + int(before)))
    return found


class DispatchNetwork(nn.Module):
    """A query over keys that are computed from contracts."""

    def __init__(self, width: int = WIDTH, rounds: int = ROUNDS) -> None:
        super().__init__()
        self.width = width
        self.of_call = _mlp(CALL_FEATURES, width)
        self.of_fact = _mlp(FACT_FEATURES, width)
        self.rounds = nn.ModuleList(_Round(width) for _ in range(rounds))
        self.query = _mlp(2 * width + 1, width)
        self.key = nn.Linear(width, width)
        self.bias = nn.Linear(width, 1)

    def forward(self, rows: Rows) -> tuple[Tensor, Tensor]:
        """Return the logarithms of the probability of each call (rows, longest), and of the end (rows,)."""
        return first_hit(self.hazards(rows))

    def hazards(self, rows: Rows) -> Tensor:
        """Return the logit of making each call, given that no earlier one is made (rows, longest)."""
        calls, facts = self.of_call(rows.calls), self.of_fact(rows.facts)
        first, again, *last = self.rounds
        calls, facts = first(calls, facts, rows)
        waits = rows.depths.clamp(max=MOST_ROUNDS) - ROUNDS + 1  # what is far from the goal is heard of late
        for number in range(1 + max(0, int(waits.max()) if rows.count else 0)):
            heard = again(calls, facts, rows)
            if number == 0:
                calls, facts = heard
            else:  # a row has as many rounds as it would have alone
                deep = waits >= number
                calls = torch.where(deep[rows.row_of_call, None], heard[0], calls)
                facts = torch.where(deep[rows.row_of_fact, None], heard[1], facts)
        for each in last:
            calls, facts = each(calls, facts, rows)
        goals = facts * rows.facts[:, 2:3]
        lacking = rows.facts[:, 2:3] * (1 - rows.facts[:, 0:1])  # of the contract, whatever was heard of it
        summary = torch.cat(
            [_most(each, rows.row_of_fact, rows.count) for each in (goals, facts, lacking)], 1
        )
        asked = self.query(summary)[rows.row_of_call]
        hazard = (asked * self.key(calls)).sum(-1) / self.width**0.5 + self.bias(calls)[:, 0]
        hazards = torch.full((rows.count, max(1, rows.longest)), LEAST)
        return hazards.index_put((rows.row_of_call, rows.places), hazard)


def first_hit(hazards: Tensor) -> tuple[Tensor, Tensor]:
    """Return the logarithms of the probability that a call is the first that is made, and that none is."""
    none = nn.functional.logsigmoid(-hazards)
    passed = none.cumsum(1)
    return nn.functional.logsigmoid(hazards) + passed - none, passed[:, -1]


class _Round(nn.Module):
    """One round of messages."""

    def __init__(self, width: int) -> None:
        super().__init__()
        self.link = _mlp(2 * width + RELATIONS, width)
        self.update_call = _mlp(6 * width, width)
        self.update_fact = _mlp(3 * width, width)
        self.norm_call, self.norm_fact = nn.LayerNorm(width), nn.LayerNorm(width)

    def forward(self, calls: Tensor, facts: Tensor, rows: Rows) -> tuple[Tensor, Tensor]:
        count = len(calls)
        given, needed = facts[rows.provides[1]], facts[rows.requires[1]]
        told = self.link(torch.cat([facts[rows.links[1]], calls[rows.links[2]], rows.relations], 1))
        heard = [
            calls,
            _most(given, rows.provides[0], count),
            -_most(-given, rows.provides[0], count),
            _most(needed, rows.requires[0], count),
            -_most(-needed, rows.requires[0], count),
            _most(told, rows.links[0], count),
        ]
        of_facts = [
            facts,
            _most(calls[rows.provides[0]], rows.provides[1], len(facts)),
            _most(calls[rows.requires[0]], rows.requires[1], len(facts)),
        ]
        return (
            self.norm_call(calls + self.update_call(torch.cat(heard, 1))),
            self.norm_fact(facts + self.update_fact(torch.cat(of_facts, 1))),
        )


def _mlp(inputs: int, width: int) -> nn.Sequential:
    return nn.Sequential(nn.Linear(inputs, width), nn.SiLU(), nn.Linear(width, width))


def _most(values: Tensor, group: Tensor, groups: int) -> Tensor:
    """Return the largest of each group's values, along each axis; zero for a group of none."""
    out = torch.zeros(groups, values.shape[1])
    index = group[:, None].expand_as(values)
    return out.scatter_reduce(0, index, values, "amax", include_self=False)
