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
from ntp_dsl.core.mlp import Mlp

WIDTH = 32
ROUNDS = 4
CALL_FEATURES, FACT_FEATURES, RELATIONS = 4, 4, 4
PROVIDED_BEFORE = 1  # the relation of a call to an earlier one that provides what it requires
MOST_ROUNDS = 24  # for the longest sequences
HEARD = 5  # by a call: the most and the least of what it provides, the same of what it requires, and links
TOLD = 2  # to a fact: by the calls that provide it, and by those that require it
LEAST = -30.0  # of a logarithm of a probability

Link = tuple[int, int, int, int]  # the call that is told, the fact, the other call, the relation


@dataclass(frozen=True)
class Messages:
    """What a round sends along edges, as one gather and one scatter: of few rows, each call of torch counts.

    Senders are calls, then facts, then facts with the opposite sign: the largest of these is the least one.
    """

    senders: Tensor  # (3 edges + 2 links,) of edges the facts, these again, the calls; of links facts, calls
    relations: Tensor  # (links, RELATIONS) one-hot: which of the two provides, and which comes first
    groups: Tensor  # (3 edges + links, 1) what is heard together
    signs: Tensor  # (HEARD calls + TOLD facts, 1) of each group


@dataclass(frozen=True)
class Rows:
    """Many rows as one graph."""

    calls: Tensor  # (calls, CALL_FEATURES)
    facts: Tensor  # (facts, FACT_FEATURES)
    row_of_call: Tensor  # (calls,)
    row_of_fact: Tensor  # (facts,)
    messages: Messages
    places: Tensor  # (calls,) of each call in its row
    depths: Tensor  # (rows,) of each row, see `_depth`
    extra_rounds: int  # for the deepest row: what is far from the goal is heard of late
    count: int  # rows
    longest: int  # calls of a row


def batched(rows: Sequence[Row]) -> Rows:
    calls: list[list[float]] = []
    facts: list[list[float]] = []
    row_of_call: list[int] = []
    row_of_fact: list[int] = []
    places: list[int] = []
    edges: list[tuple[int, int, int]] = []
    links: list[Link] = []
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
        for is_required, pairs in enumerate((row.provides, row.requires)):
            edges += [(call + first_call, fact + first_fact, is_required) for call, fact in pairs]
        found = _links(row)
        depths.append(_depth(row, found))
        links += [
            (told + first_call, fact + first_fact, other + first_call, kind)
            for told, fact, other, kind in found
        ]
    return Rows(
        torch.tensor(calls, dtype=torch.float32).reshape(-1, CALL_FEATURES),
        torch.tensor(facts, dtype=torch.float32).reshape(-1, FACT_FEATURES),
        torch.tensor(row_of_call, dtype=torch.long),
        torch.tensor(row_of_fact, dtype=torch.long),
        _messages(edges, links, len(calls), len(facts)),
        torch.tensor(places, dtype=torch.long),
        torch.tensor(depths, dtype=torch.long),
        max(0, min(max(depths, default=0), MOST_ROUNDS) - ROUNDS + 1),
        len(rows),
        max((len(row.calls) for row in rows), default=0),
    )


def _messages(
    edges: Sequence[tuple[int, int, int]], links: Sequence[Link], calls: int, facts: int
) -> Messages:
    """Return the messages along edges (a call, a fact, whether it is required) and links."""
    told = HEARD * calls
    senders = [calls + fact for _, fact, _ in edges] + [calls + facts + fact for _, fact, _ in edges]
    senders += [call for call, _, _ in edges]
    senders += [calls + fact for _, fact, _, _ in links] + [other for _, _, other, _ in links]
    groups = [HEARD * call + 2 * is_required for call, _, is_required in edges]
    groups += [HEARD * call + 2 * is_required + 1 for call, _, is_required in edges]
    groups += [told + TOLD * fact + is_required for _, fact, is_required in edges]
    groups += [HEARD * call + HEARD - 1 for call, _, _, _ in links]
    relations = [[float(kind == each) for each in range(RELATIONS)] for _, _, _, kind in links]
    signs = [1.0, -1.0, 1.0, -1.0, 1.0] * calls + [1.0] * TOLD * facts
    return Messages(
        torch.tensor(senders, dtype=torch.long),
        torch.tensor(relations, dtype=torch.float32).reshape(-1, RELATIONS),
        torch.tensor(groups, dtype=torch.long)[:, None],
        torch.tensor(signs, dtype=torch.float32)[:, None],
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
        self.of_call = Mlp(CALL_FEATURES, width, width)
        self.of_fact = Mlp(FACT_FEATURES, width, width)
        self.rounds = nn.ModuleList(_Round(width) for _ in range(rounds))
        self.query = Mlp(2 * width + 1, width, width)
        self.key = nn.Linear(width, width)
        self.bias = nn.Linear(width, 1)

    def forward(self, rows: Rows) -> tuple[Tensor, Tensor]:
        """Return the logarithms of the probability of each call (rows, longest), and of the end (rows,)."""
        return first_hit(self.hazards(rows))

    def hazards(self, rows: Rows) -> Tensor:
        """Return the logit of making each call, given that no earlier one is made (rows, longest)."""
        calls, facts = self.of_call(rows.calls), self.of_fact(rows.facts)
        first, again, *last = self.rounds
        calls, facts = first(calls, facts, rows.messages)
        for number in range(1 + rows.extra_rounds):
            heard = again(calls, facts, rows.messages)
            if number == 0:
                calls, facts = heard
            else:  # a row has as many rounds as it would have alone
                deep = rows.depths >= ROUNDS - 1 + number
                calls = torch.where(deep[rows.row_of_call, None], heard[0], calls)
                facts = torch.where(deep[rows.row_of_fact, None], heard[1], facts)
        for each in last:
            calls, facts = each(calls, facts, rows.messages)
        goals = facts * rows.facts[:, 2:3]
        lacking = rows.facts[:, 2:3] * (1 - rows.facts[:, 0:1])  # of the contract, whatever was heard of it
        told = torch.cat([goals, facts, lacking], 1)
        summary = _most(told, rows.row_of_fact[:, None], rows.count)
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
        self.link = Mlp(2 * width + RELATIONS, width, width)
        self.update_call = Mlp(6 * width, width, width)
        self.update_fact = Mlp(3 * width, width, width)
        self.norm_call, self.norm_fact = nn.LayerNorm(width), nn.LayerNorm(width)

    def forward(self, calls: Tensor, facts: Tensor, messages: Messages) -> tuple[Tensor, Tensor]:
        told, links = HEARD * len(calls), len(messages.relations)
        sent = torch.cat([calls, facts, -facts])[messages.senders]
        edges = len(sent) - 2 * links
        direct, linked = sent[:edges], sent[edges:]
        linked = self.link(torch.cat([linked[:links], linked[links:], messages.relations], 1))
        heard = _most(torch.cat([direct, linked]), messages.groups, len(messages.signs)) * messages.signs
        width = calls.shape[1]
        of_calls = torch.cat([calls, heard[:told].reshape(len(calls), HEARD * width)], 1)
        of_facts = torch.cat([facts, heard[told:].reshape(len(facts), TOLD * width)], 1)
        return (
            self.norm_call(calls + self.update_call(of_calls)),
            self.norm_fact(facts + self.update_fact(of_facts)),
        )


def _most(values: Tensor, groups: Tensor, count: int) -> Tensor:
    """Return the largest of each group's values, along each axis; zero for a group of none.

    Args:
        groups: (values, 1) that each belongs to, of `count`.
    """
    out = values.new_zeros(count, values.shape[1])
    return out.scatter_reduce(0, groups.expand_as(values), values, "amax", include_self=False)
