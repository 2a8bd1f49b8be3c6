"""The syntax tree of a task library. Nodes compare by what they mean, not by their place in the text."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path


@dataclass(frozen=True)
class Span:
    """A stretch of source text; lines and columns count from one, the end is exclusive."""

    path: Path | None
    line: int
    column: int
    end_line: int
    end_column: int

    def __str__(self) -> str:
        return f"{self.path or '<text>'}:{self.line}:{self.column}"


NOWHERE = Span(None, 0, 0, 0, 0)


@dataclass(frozen=True)
class Node:
    span: Span = field(default=NOWHERE, compare=False, repr=False, kw_only=True)


# Expressions -----------------------------------------------------------------------------------


@dataclass(frozen=True)
class Name(Node):
    """A parameter, a loop variable, a constant, an enumeration's member or a type."""

    id: str


@dataclass(frozen=True)
class Field(Node):
    """`p.item`: a field of a record."""

    value: Name
    name: str


@dataclass(frozen=True)
class Wildcard(Node):
    """`any`, as in `holding(any)`: some object, no matter which."""


@dataclass(frozen=True)
class Number(Node):
    """A number as written, with its unit (`0.25 m`) or none."""

    value: float
    unit: str = ""
    is_unit_shared: bool = field(default=False, compare=False, repr=False)  # with a range's upper bound


ZERO = Number(0.0)


@dataclass(frozen=True)
class Arithmetic(Node):
    """A term that is calculated; `-x` is `0 - x`."""

    operator: str  # + - * /
    left: Expression
    right: Expression


@dataclass(frozen=True)
class Atom(Node):
    """A predicate applied to terms: `on(item, support)`; also a numeric reading, `opening(d)`."""

    predicate: str
    arguments: tuple[Expression, ...] = ()


@dataclass(frozen=True)
class Compare(Node):
    operator: str  # == != < <= > >=
    left: Expression
    right: Expression


@dataclass(frozen=True)
class Not(Node):
    value: Expression


@dataclass(frozen=True)
class And(Node):
    values: tuple[Expression, ...]


@dataclass(frozen=True)
class Or(Node):
    values: tuple[Expression, ...]


@dataclass(frozen=True)
class Generator(Node):
    """`for p in goal if c`: elements of a list, of the scene where `iterable` names a type, or members."""

    variable: str
    iterable: Name
    condition: Expression | None = None


@dataclass(frozen=True)
class Quantified(Node):
    """`all BODY for …`, or `some`, `exactly 2`, `at least 2`.

    Over no elements, `all` is true and `some` false.
    """

    quantifier: str  # all, some, exactly, at least
    body: Expression
    generators: tuple[Generator, ...]
    count: int | None = None  # of the last two


Expression = Name | Field | Wildcard | Number | Arithmetic | Atom | Compare | Not | And | Or | Quantified


# Statements ------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Call(Node):
    callee: str
    arguments: tuple[Expression, ...] = ()


@dataclass(frozen=True)
class When(Node):
    """`when c: call`: as if not written where c is false. `else: call` is a `when` of the opposite."""

    condition: Expression
    body: Statement
    is_else: bool = False


@dataclass(frozen=True)
class For(Node):
    """One call per element; nested loops (`for m in goal: for o in T if c:`) are nested nodes."""

    generator: Generator
    body: Statement


Statement = Call | When | For


# Declarations ----------------------------------------------------------------------------------


@dataclass(frozen=True)
class TypeName(Node):
    """`Block`, or `list[Placement]`."""

    name: str
    is_list: bool = False


@dataclass(frozen=True)
class Parameter(Node):
    """`item: Object`, or a number with its range: `distance: length in 0 .. 0.3 m`."""

    name: str
    type: TypeName
    low: Number | None = None
    high: Number | None = None


@dataclass(frozen=True)
class Declaration(Node):
    name: str
    docstring: str = field(default="", kw_only=True)
    name_span: Span = field(default=NOWHERE, compare=False, repr=False, kw_only=True)


@dataclass(frozen=True)
class TypeDeclaration(Declaration):
    """`type Block is Movable`; a type without a parent stands by itself."""

    parent: TypeName | None = None


@dataclass(frozen=True)
class EnumDeclaration(Declaration):
    """`enum Side: left, right`."""

    members: tuple[str, ...] = ()
    member_spans: tuple[Span, ...] = field(default=(), compare=False, repr=False, kw_only=True)


@dataclass(frozen=True)
class RecordDeclaration(Declaration):
    """`record Placement(item: Object, support: Place)`: an element of the list that is a goal."""

    fields: tuple[Parameter, ...] = ()


@dataclass(frozen=True)
class ConstantDeclaration(Declaration):
    """`constant table: Table`: an object that every scene has."""

    type: TypeName = TypeName("")


PYTHON = "python"  # `by python`: a function of the same name in the file beside the library
STATE = "state"  # `by state`: a fact that holds from when an api achieves it until one undoes it


@dataclass(frozen=True)
class PredicateDeclaration(Declaration):
    """`predicate on(item: Object, support: Place)`: decided by the world, or composed, by a body.

    With a result (`predicate opening(d: Drawer) -> length`) it is a reading: a number, or a member
    of an enumeration. `by` names the world's predicate, if that has another name, Python, or the state.
    """

    parameters: tuple[Parameter, ...] = ()
    body: Expression | None = None
    result: TypeName | None = None
    by: Name | None = None

    @property
    def is_state(self) -> bool:
        """Return whether it is a fact of the state."""
        return self.body is None and self.by is not None and self.by.id == STATE

    @property
    def provider(self) -> str:
        """Return the name of what evaluates a predicate without a body."""
        return self.by.id if self.by else self.name


@dataclass(frozen=True)
class ApiDeclaration(Declaration):
    """A primitive. `by` names the world's skill, if that has another name, or Python."""

    parameters: tuple[Parameter, ...] = ()
    requires: Expression | None = None
    achieves: Expression | None = None
    says: tuple[Text, ...] = ()
    by: Name | None = None


@dataclass(frozen=True)
class ProgramDeclaration(Declaration):
    """A program. With `by python` an expert in Python decides, and `calls` says what it may call."""

    parameters: tuple[Parameter, ...] = ()
    requires: Expression | None = None
    achieves: Expression | None = None
    says: tuple[Text, ...] = ()
    body: tuple[Statement, ...] = ()
    by: Name | None = None
    calls: tuple[Name, ...] = ()


@dataclass(frozen=True)
class Interval(Node):
    """`0.3 .. 0.7 m`: a range from which a number is drawn."""

    low: Number
    high: Number


@dataclass(frozen=True)
class Text(Node):
    """`"bowl.urdf"`: a file beside the library, or a sentence."""

    value: str


Setting = Number | Interval | Name | Text


@dataclass(frozen=True)
class Detail(Node):
    """`box(5 cm, 5 cm, 5 cm)`, `colour(red, green)`: what the objects of a group look like."""

    name: str
    settings: tuple[Setting, ...] = ()


@dataclass(frozen=True)
class SceneGroup(Node):
    """`blocks: 4..8 Block on table with cube(5 cm)`: objects of a type, and where they start.

    Without a number it is one object, which is called like the group: `mug: Cup on table`.
    """

    name: str
    count: int
    type: TypeName
    place: str = "table"
    most: int | None = None  # where the count is a range
    details: tuple[Detail, ...] = ()
    is_single: bool = False
    place_span: Span = field(default=NOWHERE, compare=False, repr=False, kw_only=True)


@dataclass(frozen=True)
class Varied(Node):
    """`blocks: 10`: another number of what the shared scene has."""

    name: str
    count: int
    most: int | None = None


@dataclass(frozen=True)
class SharedScene(Node):
    """`as TASK`, or `as TASK with` groups that are other or more: the scene of a task above."""

    task: str
    own: tuple[SceneGroup | Varied, ...] = ()
    initially: tuple[Atom, ...] = ()  # of that task
    task_span: Span = field(default=NOWHERE, compare=False, repr=False, kw_only=True)


@dataclass(frozen=True)
class Option(Node):
    """`placements=1..6`, `height=4`: a sampler's option; a single number is a range of one."""

    name: str
    low: int
    high: int


@dataclass(frozen=True)
class Sampler(Node):
    """`towers(blocks, placements=1..6, height=2..4)`: how a task draws its goals.

    `-> list[Mapping]` says what the goal is a list of; `by python` that a function draws it.
    """

    name: str
    groups: tuple[str, ...] = ()
    options: tuple[Option, ...] = ()
    result: TypeName | None = None
    by: Name | None = None
    group_spans: tuple[Span, ...] = field(default=(), compare=False, repr=False, kw_only=True)


@dataclass(frozen=True)
class Row(Node):
    """`(mug, left_plate)`: an element of a goal that is given, one term for each field."""

    terms: tuple[Expression, ...]


@dataclass(frozen=True)
class GivenGoal(Node):
    """`(mug, left_plate), (bowl, right_plate)`: a goal in so many words, with `-> list[Mapping]` or none."""

    rows: tuple[Row, ...]
    result: TypeName | None = None


Goal = Sampler | GivenGoal


@dataclass(frozen=True)
class TaskDeclaration(Declaration):
    """A task. `initially` are the facts of the state that hold at the start.

    Where it shares a scene, `scene` is what it comes to, with its own groups.
    """

    scene: tuple[SceneGroup, ...] = ()
    shared: SharedScene | None = None
    initially: tuple[Atom, ...] = ()
    goal: Goal | None = None
    run: Call | None = None
    success: Expression | None = None

    @property
    def facts(self) -> tuple[Atom, ...]:
        """Return the facts of the state that hold at the start: its own, or else those of a shared scene."""
        return self.initially or (self.shared.initially if self.shared else ())

    @property
    def sampler(self) -> Sampler | None:
        """Return how the goal is drawn; None where it is given, or where there is none."""
        return self.goal if isinstance(self.goal, Sampler) else None


@dataclass(frozen=True)
class Use(Node):
    """`use tabletop`: another library's declarations."""

    library: str


@dataclass(frozen=True)
class Library:
    """A parsed library, not yet checked. `check` turns it into a `Registry`."""

    name: str
    uses: tuple[Use, ...] = ()
    declarations: tuple[Declaration, ...] = ()
    docstring: str = ""
    path: Path | None = field(default=None, compare=False)
