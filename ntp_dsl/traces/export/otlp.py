"""Traces as OpenTelemetry spans, in the JSON of its protocol (OTLP), which Jaeger, Tempo and others take.

https://opentelemetry.io/docs/specs/otlp: identities are hexadecimal, and 64-bit integers are strings.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from hashlib import sha256
from typing import Any

import msgspec

from ntp_dsl.traces.export.slices import details, slices
from ntp_dsl.traces.phrases import format_call
from ntp_dsl.traces.schema import ROOT, Call
from ntp_dsl.traces.trace import Trace

INTERNAL = 1  # the kind of a span
OK, ERROR = 1, 2  # its status

Row = dict[str, Any]


def document(traces: Sequence[Trace], ended: Sequence[float]) -> Row:
    """Return the protocol's JSON object: a resource for each trace.

    Args:
        ended: when each of them ended, since 1970 [s]; the spans lie before.
    """
    return {"resourceSpans": [_resource(*pair) for pair in zip(traces, ended, strict=True)]}


def _resource(trace: Trace, ended: float) -> Row:
    header = trace.header
    origin = {
        "service.name": "ntp",
        "ntp.library": header.library,
        "ntp.task": header.task,
        "ntp.policy": header.policy,
        "ntp.world": header.world,
        "ntp.seed": header.seed,
        "ntp.episode": header.episode,
    }
    known = {name: value for name, value in origin.items() if value not in (None, "")}
    identity = sha256(msgspec.json.encode((header, trace.calls))).hexdigest()[:32]
    spans = [*_spans(trace, identity, ended)]
    return {
        "resource": {"attributes": _attributes(known)},
        "scopeSpans": [{"scope": {"name": "ntp_dsl"}, "spans": spans}],
    }


def _spans(trace: Trace, identity: str, ended: float) -> Iterator[Row]:
    """Yield a span for each call, and for the parts of calls."""
    found = slices(trace)
    start = max(0, round(1e9 * ended) - 1000 * max((each.end for each in found), default=0))
    for number, each in enumerate(found):
        call = each.call
        span: Row = {
            "traceId": identity,
            "spanId": _of_part(number) if each.part else _of_call(call.id),
            "name": each.part or format_call(call),
            "kind": INTERNAL,
            "startTimeUnixNano": str(start + 1000 * each.begin),
            "endTimeUnixNano": str(start + 1000 * each.end),
        }
        if each.above != ROOT:
            span["parentSpanId"] = _of_call(each.above)
        if not each.part:
            span["attributes"] = _attributes({f"ntp.{name}": value for name, value in details(call).items()})
            span["status"] = _status(call)
        yield span


def _status(call: Call) -> Row:
    if call.outcome is None:
        return {}
    return {"code": OK} if call.succeeded else {"code": ERROR, "message": str(call.outcome)}


def _of_call(number: int) -> str:
    return f"{number + 1:016x}"


def _of_part(number: int) -> str:
    return f"{(1 << 63) + number:016x}"


def _attributes(values: dict[str, Any]) -> list[Row]:
    return [{"key": name, "value": _value(value)} for name, value in values.items()]


def _value(value: Any) -> Row:
    match value:
        case bool():
            return {"boolValue": value}
        case int() if abs(value) < 1 << 63:
            return {"intValue": str(value)}
        case float():
            return {"doubleValue": value}
        case str():
            return {"stringValue": str(value)}
        case list() | tuple():
            return {"arrayValue": {"values": [_value(each) for each in value]}}
    return {"stringValue": json.dumps(value, default=str)}
