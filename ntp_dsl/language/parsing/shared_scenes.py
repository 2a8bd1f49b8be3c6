"""Scenes that tasks share: `scene: as TASK` is what that task has, with groups that are other or more."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

from ntp_dsl.language.diagnostics.diagnostics import Diagnostic, unknown
from ntp_dsl.language.syntax.nodes import Declaration, SceneGroup, SharedScene, TaskDeclaration, Varied


def with_shared_scenes(
    declarations: Sequence[Declaration],
) -> tuple[tuple[Declaration, ...], list[Diagnostic]]:
    """Return the declarations with the scenes that they come to, and what is wrong with sharing."""
    tasks: dict[str, TaskDeclaration] = {}
    found: list[Declaration] = []
    diagnostics: list[Diagnostic] = []
    for each in declarations:
        if isinstance(each, TaskDeclaration):
            if each.shared is not None:
                diagnostics += _flaws(each.shared, tasks)
                each = _resolved(each, each.shared, tasks.get(each.shared.task))
            tasks.setdefault(each.name, each)
        found.append(each)
    return tuple(found), diagnostics


def _resolved(task: TaskDeclaration, shared: SharedScene, base: TaskDeclaration | None) -> TaskDeclaration:
    if base is None:
        return replace(task, scene=tuple(each for each in shared.own if isinstance(each, SceneGroup)))
    own = {each.name: each for each in shared.own}
    known = {group.name for group in base.scene}
    groups = [_varied(group, own.get(group.name)) for group in base.scene]
    groups += [each for each in shared.own if isinstance(each, SceneGroup) and each.name not in known]
    return replace(task, scene=tuple(groups), shared=replace(shared, initially=base.facts))


def _varied(group: SceneGroup, own: SceneGroup | Varied | None) -> SceneGroup:
    match own:
        case Varied(count=count, most=most):
            return replace(group, count=count, most=most, is_single=False, span=own.span)
        case None:
            return group
    return own


def _flaws(shared: SharedScene, tasks: dict[str, TaskDeclaration]) -> Iterator[Diagnostic]:
    base = tasks.get(shared.task)
    if base is None:
        yield unknown("E101", "no task above is called", shared.task, shared.task_span, tasks)
        return
    known = {group.name for group in base.scene}
    for index, each in enumerate(shared.own):
        if each.name in {other.name for other in shared.own[:index]}:
            message = f"'{each.name}' is there twice; one of the two is enough"
            yield Diagnostic("E305", message, each.span)
        if not isinstance(each, SceneGroup) and each.name not in known:
            yield unknown("E106", "the shared scene has no group", each.name, each.span, known)
