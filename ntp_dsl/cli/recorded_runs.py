"""What a trace was recorded with: its library, and what somebody answered."""

from __future__ import annotations

from pathlib import Path

from ntp_dsl.common.resources import examples_folder
from ntp_dsl.common.text import printable
from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.language.registry import Registry
from ntp_dsl.policies.protocol import Policy
from ntp_dsl.semantics.observation import Record
from ntp_dsl.traces.schema import ROOT
from ntp_dsl.traces.trace import Trace
from ntp_dsl.user_code.loading import load_with_python


def registry_path(trace: Trace) -> Path:
    """Return the shipped example that a trace names.

    Raises `NtpError` for any other library: its Python would run on a trace's word.
    """
    shipped = {path.name: path for path in examples_folder().iterdir() if path.is_dir()}
    if trace.header.library not in shipped:
        raise NtpError(
            f"the trace is of library '{printable(trace.header.library)}', which is no example: "
            "give its path with --library"
        )
    return shipped[trace.header.library]


def registry_of(trace: Trace, library: Path | None, file: Path) -> Registry:
    """Return the library of a trace. Raises `NtpError` where it is another, or has changed since."""
    for field, value in (("library", trace.header.library), ("task", trace.header.task)):
        if not value:
            raise NtpError(f"{file}: the trace names no {field}, so it cannot be replayed")
    path = library or registry_path(trace)
    registry = load_with_python(path)
    if registry.hash != trace.header.registry:
        raise NtpError(
            f"{file}: was recorded with another version of library '{trace.header.library}' "
            f"({trace.header.registry}); expected {registry.hash}, of {path}; give the one that it was "
            "recorded with as --library"
        )
    return registry


def heed_answers(trace: Trace, policy: Policy) -> None:
    """Let a policy take what somebody answered when the trace was made, of its lists and of what to do."""
    from ntp_dsl.core.asking import Repeated
    from ntp_dsl.core.policy import OneShotPolicy
    from ntp_dsl.core.shown import Shown

    if not isinstance(policy, OneShotPolicy):
        return
    policy.adviser = Repeated(
        [(call.name, call.arguments, seen, asked) for call, seen, asked in trace.questions()]
    )
    if not isinstance(policy.source, Shown):
        return
    source = policy.source
    for call, read in trace.readings():
        said = {(each.parameter, each.number): each.answer for each in read.doubts if each.answer is not None}
        if not said or call.parent != ROOT:
            continue  # programs that a list is passed on to heed the answers of the root
        wanted = call.name, call.arguments, source.scope()
        doubts = source.reading(*wanted).doubts
        answers = {each: said.get((each.parameter, each.number)) for each in doubts}
        source.settle(
            *wanted,
            {each: answer for each, answer in answers.items() if isinstance(answer, Record | str)},
        )
