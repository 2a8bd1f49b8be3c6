"""The scripted policy: an expert that also gives each call its part of the demonstration."""

from __future__ import annotations

from ntp_dsl.language.registry import Registry
from ntp_dsl.policies.expert import Expert, NextCall, Return
from ntp_dsl.policies.protocol import Barred, Choice, Frame
from ntp_dsl.semantics.observation import Argument, Record, without_lists
from ntp_dsl.semantics.value_checks import check_ranges
from ntp_dsl.traces.decision import Decision
from ntp_dsl.traces.schema import Call, DemonstratedCall, PolicyKind
from ntp_dsl.traces.trace import Trace
from ntp_dsl.worlds.protocol import World


def demonstrated(trace: Trace) -> DemonstratedCall:
    """Return the call tree of a demonstration's own trace: its busiest root, over all frames."""
    nodes: dict[int, DemonstratedCall] = {}
    roots = []
    for call in trace.calls:
        node = _node(call)
        nodes[call.id] = node
        if call.parent in nodes:
            nodes[call.parent].children.append(node)
        else:
            roots.append(node)
    busiest = max(roots, key=lambda root: len(root.children))
    last = max(node.scope[1] for node in nodes.values())
    busiest.scope = (0, last)
    return busiest


def _node(call: Call) -> DemonstratedCall:
    end = call.end_frame if call.end_frame is not None else call.frame
    return DemonstratedCall(
        name=call.name, arguments=call.arguments, scope=(call.frame, end), done=call.succeeded
    )


def counterpart(
    caller: DemonstratedCall | None, callee: str, arguments: tuple[Argument, ...]
) -> DemonstratedCall | None:
    """Return the caller's last child of the same program and objects that returned done."""
    if caller is None:
        return None
    same = [c for c in caller.children if c.name == callee and alike(c.arguments, arguments) and c.done]
    return same[-1] if same else _hull(caller, callee, arguments)


def like_calls(
    caller: DemonstratedCall, callee: str, arguments: tuple[Argument, ...]
) -> list[DemonstratedCall]:
    """Return a caller's calls of the same program or api and objects, whatever their lists."""
    given = without_lists(arguments)
    return [c for c in caller.children if c.name == callee and alike(without_lists(c.arguments), given)]


def alike(some: tuple[Argument, ...], others: tuple[Argument, ...]) -> bool:
    """Return whether arguments agree, ignoring numbers, which depend on where objects are."""
    return _named(some) == _named(others)


def _named(arguments: tuple[Argument, ...]) -> list[Argument]:
    """Return objects and members, those of records too, and lists unchanged."""
    flat = [argument for argument in arguments if isinstance(argument, tuple)]
    return [*flat, *(value for value in without_lists(arguments) if not isinstance(value, float))]


def shown_anywhere(
    root: DemonstratedCall, program: str, arguments: tuple[Argument, ...]
) -> DemonstratedCall | None:
    """Return the last call of a program that returned done, anywhere in the tree."""
    same = [c for c in root.walk() if c.name == program and alike(c.arguments, arguments) and c.done]
    return same[-1] if same else None


def _hull(caller: DemonstratedCall, callee: str, arguments: tuple[Argument, ...]) -> DemonstratedCall | None:
    """Return, for a callee that takes a list, a call over all frames in which its elements were handled."""
    elements = [e for a in arguments if isinstance(a, tuple) for e in a]
    wanted = {tuple(v for _, v in e.fields) for e in elements if isinstance(e, Record)}
    calls = [call for call in caller.walk() if without_lists(call.arguments) in wanted and call.done]
    if not calls:
        return None
    scope = (min(c.scope[0] for c in calls), max(c.scope[1] for c in calls))
    return DemonstratedCall(name=callee, arguments=arguments, scope=scope, done=True, children=calls)


def source_of(decision: NextCall) -> str:
    """Return the place of the statement that makes a call, as `file:line`."""
    span = decision.span
    return f"{span.path.name}:{span.line}" if span.path else ""


def check_numbers(registry: Registry, decision: NextCall) -> None:
    """Raise `OutOfRange` where a program or api would be called with a number outside of its range."""
    check_ranges(registry[decision.callee], decision.arguments, decision.span)


class ScriptedPolicy:
    """Decides by the expert, from the true state; scopes follow from the demonstration, if there is one."""

    kind = PolicyKind.SCRIPTED

    def __init__(self, expert: Expert, demonstration: DemonstratedCall | None = None) -> None:
        self.expert = expert
        self.demonstration = demonstration

    def root(self, program: str, arguments: tuple[Argument, ...]) -> Frame:
        shown = self.demonstration
        return Frame(program, arguments, shown.scope if shown else None, shown)

    def decide(self, frame: Frame, world: World, barred: Barred = frozenset()) -> Choice:
        """Return the expert's choice; it never makes a forbidden call, so `barred` is not needed."""
        seen = world.truth()
        decision = self.expert.decide(frame.program, frame.arguments, self.expert.state_of(seen))
        if isinstance(decision, Return):
            return Choice(None, done=decision.done, decision=Decision(reason=decision.reason), seen=seen)
        check_numbers(self.expert.registry, decision)
        shown = counterpart(frame.matched, decision.callee, decision.arguments)
        return Choice(
            decision.callee,
            decision.arguments,
            shown.scope if shown else None,
            matched=shown,
            decision=Decision(source=source_of(decision)),
            seen=seen,
        )
