"""The document that the page's script reads: plain text and finite numbers, and nothing else."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from msgspec import Struct

from ntp_dsl.semantics.geometry import Quaternion, Vector
from ntp_dsl.traces.decision import Frames

NO_ROW = -1
Text = int  # number of a text in the document's table
Ranking = Sequence[tuple[str, float]]  # alternatives with their probabilities, most probable first
Moment = tuple[int, float, Vector, bool, Mapping[str, Vector]]  # frame, time, hand, closed, moved objects
Turn = tuple[int, Mapping[str, Quaternion]]  # frame, objects that were turned


class PageObject(Struct, frozen=True):
    """An object of a scene."""

    type: str
    size: Vector  # full extents [m]
    shape: str


class PageScene(Struct, frozen=True):
    """Objects in motion, and the camera's pictures of them."""

    title: str
    objects: Mapping[str, PageObject]
    motion: Sequence[Moment]
    turns: Sequence[Turn]
    pictures: Sequence[tuple[int, str]]  # frame, data URI


class PageFact(Struct, frozen=True, array_like=True):
    """A fact that a decision rests on."""

    text: Text
    probability: float
    truth: bool | None


class PageStatement(Struct, frozen=True, array_like=True):
    """A statement of the deciding program, and what the call that it stands for lacked."""

    text: Text
    line: int
    status: str
    lacks: Sequence[Text]


class PageDecision(Struct, frozen=True):
    """A decision: its alternatives, and what it rested on."""

    notes: Sequence[str]
    alternatives: Sequence[tuple[str, Ranking]]  # each with its title
    facts: Sequence[PageFact]
    statements: Sequence[PageStatement]


class PageCall(Struct, frozen=True):
    """A call of one trace."""

    name: str
    program: bool
    arguments: str
    names: Sequence[str]  # of the objects among its arguments
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
    unmet: Sequence[str]
    evidence: str
    holds: Sequence[Text]  # facts of the state, when it was called
    became: Sequence[str]  # what of that state had changed when it had ended
    made: PageDecision  # by its caller
    returned: PageDecision | None  # by itself


class PageTrace(Struct, frozen=True):
    """One of the traces."""

    origin: str
    ending: str  # who decided, and how that ended
    calls: Sequence[PageCall]
    scene: PageScene
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
    differences: str  # between the states of the two decisions


class PageDemonstration(Struct, frozen=True):
    """The demonstration's length, its top-level calls, and the frames in which the hand was closed."""

    frames: int
    calls: Sequence[tuple[str, Frames]]
    closed: Sequence[Frames]
    scene: PageScene | None  # None where only its scopes are known
    said: Sequence[str] = ()  # sentences in place of a demonstration


class PageDocument(Struct, frozen=True):
    """Everything that a page shows."""

    summary: str
    texts: Sequence[str]
    traces: Sequence[PageTrace]
    rows: Sequence[PageRow]
    divergences: Sequence[PageDivergence]
    frames: int
    demonstration: PageDemonstration
    overview: str = ""  # why a single episode failed
    begins_at: int = 0  # the row that is shown first
    goes_on: bool = False  # a run that is not over
    waits_for: str = ""  # the decision before which it waits
