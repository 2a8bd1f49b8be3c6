"""What a trace has to be like so that a policy can be asked at its states: checked once, before a replay."""

from __future__ import annotations

from ntp_dsl.common.text import counted, printable
from ntp_dsl.demonstrations.demonstration import Demonstration, check_objects
from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.language.registry import Parameter, Program, Registry
from ntp_dsl.semantics.observation import Argument, Record
from ntp_dsl.semantics.value_checks import Types, misfit
from ntp_dsl.traces.phrases import format_argument
from ntp_dsl.traces.schema import ROOT, Call
from ntp_dsl.traces.trace import Trace

AGAIN = "the trace is damaged or of another library: record it again"


def check_replayable(registry: Registry, trace: Trace) -> None:
    """Raise `NtpError` for the first object or call of a trace that a library cannot have made.

    The arguments of primitives are not checked: no policy is asked what a primitive does.
    """
    types = dict(registry.constants) | {obj.name: obj.type for obj in trace.header.objects}
    for name, type_name in types.items():
        if type_name not in registry.parents:
            raise _refusal(f"'{name}' is a {type_name}, a type that library '{registry.name}' lacks")
    for call in trace.calls:
        _check_call(registry, trace, call, types)


def _check_call(registry: Registry, trace: Trace, call: Call, types: Types) -> None:
    if call.name not in (registry.programs if call.is_program else registry.apis):
        lacked = f"the {call.kind} '{call.name}', which library '{registry.name}' lacks"
        raise _refusal(f"call {call.id} is of {lacked}")
    if not call.is_program:
        return
    program = registry.programs[call.name]
    given = [call.arguments]
    if call.parent == ROOT:
        given = [each for each in (call.arguments, trace.header.arguments) if each]
    for arguments in given:
        if flaw := _unfit(registry, program, arguments, types):
            raise _refusal(f"call {call.id}, of '{call.name}', {flaw}")


def _unfit(registry: Registry, program: Program, arguments: tuple[Argument, ...], types: Types) -> str:
    """Return what is wrong with arguments, or an empty string; a learned program is given no lists."""
    parameters = program.parameters
    if len(arguments) != len(parameters):
        parameters = tuple(each for each in parameters if not each.is_list)
    if len(arguments) != len(parameters):
        return f"expected {counted(len(program.parameters), 'argument')}, found {len(arguments)}"
    for parameter, value in zip(parameters, arguments, strict=True):
        if expected := _unfit_value(registry, parameter, value, types):
            found = format_argument(value)
            return f"expected {expected} for '{parameter.name}: {parameter.type}', found {found}"
    return ""


def _unfit_value(registry: Registry, parameter: Parameter, value: Argument, types: Types) -> str:
    """Return what was expected of a value, of its elements or of its fields, or an empty string."""
    if expected := misfit(registry, parameter, value, types):
        return expected
    if isinstance(value, tuple):
        element = Parameter(parameter.name, parameter.type)
        return next(filter(None, (_unfit_value(registry, element, each, types) for each in value)), "")
    return _unfit_record(registry, value, types) if isinstance(value, Record) else ""


def _unfit_record(registry: Registry, record: Record, types: Types) -> str:
    fields = registry.records[record.type]
    if [each.name for each in fields] != [name for name, _ in record.fields]:
        return f"the fields {', '.join(each.name for each in fields)}"
    given = zip(fields, record.fields, strict=True)
    return next(filter(None, (misfit(registry, field, value, types) for field, (_, value) in given)), "")


def _refusal(found: str) -> NtpError:
    return NtpError(f"{printable(found)}; {AGAIN}")


def check_shown(trace: Trace, demonstration: Demonstration) -> None:
    """Raise `NtpError` unless a trace's scopes can refer to a demonstration: its length, and its objects."""
    check_objects(demonstration, trace.header.objects)
    reference, found = trace.header.demonstration, len(demonstration)
    if reference is not None and reference.frames != found:
        raise NtpError(
            f"the trace is of a demonstration of {reference.frames} frames, and this one has {found}; "
            "give the trace's own with --demo"
        )
    last = max((call.scope[1] for call in trace.calls if call.scope), default=0)
    if last > found:
        raise _refusal(f"the trace has a scope up to frame {last}, and the demonstration has {found}")
