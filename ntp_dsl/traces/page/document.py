"""The document that the page's script reads: plain text and finite numbers, and nothing else."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from msgspec import Struct

from ntp_dsl.semantics.geometry import Vector
from ntp_dsl.traces.decision import Frames

NO_ROW = -1
Ranking = Sequence[tuple[str, float]]  # alternatives with their probabilities, most probable first
Moment = tuple[int, float, Vector, bool, Mapping[str, Vector]]  # frame, time, hand, closed, moved objects


class PageCall(Struct, frozen=True):
    """A call of one trace."""

    name: str
    program: bool
    arguments: str
    scope: Frames | None
    outcome: str  # empty where the trace was cut off
    probability: float | None
    times: tuple[float, float, float]  # deciding, planning, moving [s]
    frame: int
    end_frame: int | None
    source: str
    statement: str
    attributed_to: str
    disturbances: Sequence[str]
    evidence: str
    alternatives: Sequence[tuple[str, Ranking]]  # each with its title


class PageTrace(Struct, frozen=True):
    """One of the traces."""

    headline: str
    calls: Sequence[PageCall]
    motion: Sequence[Moment]
    sizes: Mapping[str, Vector]
    pictures: Sequence[tuple[int, str]]  # frame, data URI
    frames: int


class PageRow(Struct):
    """A row of the aligned trees: a call of the first trace, of the second, or of both."""

    a: int | None
    b: int | None
    depth: int
    mark: str  # same, changed, only a, only b
    parent: int  # row of the caller, or `NO_ROW`
    end: int = 0  # the row after all rows below
    unchanged: bool = True  # whether neither it nor anything below it differs


class PageDivergence(Struct, frozen=True):
    """A divergence, as text."""

    kind: str
    attributed_to: str
    row: int  # or `NO_ROW` for the run itself
    a: int | None  # call to show for each trace
    b: int | None
    did_a: str
    did_b: str
    source: str
    statement: str
    margin: float | None
    rank: int | None
    state_distance: float | None  # [m]


class PageDemonstration(Struct, frozen=True):
    """The demonstration's length, its top-level calls, and the frames in which the hand was closed."""

    frames: int
    calls: Sequence[tuple[str, Frames]]
    closed: Sequence[Frames]


class PageDocument(Struct, frozen=True):
    """Everything that a page shows."""

    summary: str
    traces: Sequence[PageTrace]
    rows: Sequence[PageRow]
    divergences: Sequence[PageDivergence]
    frames: int
    demonstration: PageDemonstration
