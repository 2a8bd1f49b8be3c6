"""Conversion of lines of old versions of the format, which are read but no longer written."""

from __future__ import annotations

import json
from collections.abc import Mapping
from math import isinf
from typing import Any

import msgspec
from msgspec import ValidationError

from ntp_dsl.semantics.geometry import Vector, orientation_with_extents

OLDEST = 2
SHOWN = 80  # [bytes] of a line in a message
Row = dict[str, Any]


def old_row(line: bytes) -> Row:
    """Return a line of an old version, whose writer knew NaN and Infinity: they are read as words.

    Raises `ValueError`.
    """
    row = json.loads(line, parse_constant=str, parse_float=_finite)
    if not isinstance(row, dict):
        raise ValueError("expected an object with an 'event'")
    return row


def _finite(text: str) -> float:
    if isinf(value := float(text)):
        raise ValueError(f"expected a number that fits a float, found {text}")
    return value


class Upgrade:
    """Converts the lines of one file, in order, to the current version.

    Version 2 had untyped decisions, extents of tipped objects instead of orientations, and the end of a run
    in words.
    """

    def __init__(self, version: int) -> None:
        assert version == OLDEST
        self._sizes: dict[str, Vector] = {}
        self._events = {
            "header": self._header,
            "state": self._state,
            "call": self._call,
            "return": self._return,
            "end": self._end,
        }

    def row(self, old: Row) -> Row:
        """Return a line in the current version. Raises `ValidationError`."""
        try:
            return self._events.get(old["event"], dict)(old)
        except KeyError as error:
            raise ValidationError(f"it lacks {error}") from error
        except (TypeError, AttributeError, IndexError) as error:
            found = msgspec.json.encode(old)[:SHOWN].decode(errors="replace")
            raise ValidationError(f"expected the fields of version {OLDEST}, found {found}") from error
        except ValueError as error:
            raise ValidationError(str(error)) from error

    def _header(self, old: Row) -> Row:
        objects = old["things"]
        self._sizes = {each["name"]: each["size"] for each in objects}
        row = {name: value for name, value in old.items() if name not in ("things", "model", "demonstration")}
        row |= {"objects": objects, "model": old.get("model")}
        row["arguments"] = arguments = [_argument(each) for each in old.get("arguments", ())]
        lists = [each for each in arguments if isinstance(each, list) and each]
        type_name = next((each[0]["type"] for each in lists if isinstance(each[0], dict)), "")
        row["goal"] = [{"type": type_name, "fields": list(each.items())} for each in old.get("goal", ())]
        if reference := old.get("demonstration"):
            calls = reference.get("calls")
            row["demonstration"] = {**reference, "calls": _demonstrated(calls) if calls else None}
        return row

    def _state(self, old: Row) -> Row:
        tipped = old.get("tipped", {})
        turns = {name: orientation_with_extents(self._sizes[name], size) for name, size in tipped.items()}
        return {**old, "orientations": turns}

    def _call(self, old: Row) -> Row:
        arguments = [_argument(each) for each in old["arguments"]]
        return {**old, "arguments": arguments, "decision": _decision(old.get("decision", {}), arguments)}

    def _return(self, old: Row) -> Row:
        fields = ("event", "id", "outcome", "frame", "state")
        row: Row = {name: old[name] for name in fields if name in old}
        execution = {name: value for name, value in old.items() if name not in row}
        decision = execution.pop("decision", None)
        if decision is not None:
            row["decision"] = _decision(decision, [])
        return {**row, "execution": execution}

    def _end(self, old: Row) -> Row:
        reason = old.get("reason", "")
        ending = "done" if old.get("done") else "unfinished" if reason.startswith("unfinished") else "stopped"
        row = {**old, "ending": ending, "attributed_to": old.get("blame") or None}
        return {name: value for name, value in row.items() if name not in ("done", "blame")}


def _decision(old: Row, arguments: list[Any]) -> Row:
    fields = ("source", "reason", "seconds", "probability", "end_probability", "scopes")
    row = {name: old[name] for name in fields if name in old}
    row["callees"] = old.get("top", [])
    row["arguments"] = _rankings(old, arguments)
    if answer := old.get("answer"):
        given = [_argument(each) for each in answer.get("arguments", ())]
        row["answer"] = {
            "callee": answer["callee"],
            "is_api": answer.get("kind") == "api",
            "arguments": given,
            "scope": answer.get("scope"),
        }
        row["arguments"] = _rankings(old, given)
    return row


def _rankings(old: Row, arguments: list[Any]) -> list[Any]:
    """Return a ranking for each argument. Version 2 ranked objects and values separately, in order."""
    waiting = [list(old.get("pointers", ())), list(old.get("values", ()))]
    rankings = []
    for argument in _flat(arguments):
        kind = next((kind for kind in waiting if kind and kind[0] and kind[0][0][0] == argument), None)
        rankings.append(kind.pop(0) if kind else [])
    return rankings if any(rankings) else []


def _flat(arguments: list[Any]) -> list[Any]:
    """Return what `without_lists` returns, for arguments that are not yet converted to records."""
    flat: list[Any] = []
    for each in arguments:
        if isinstance(each, dict):
            flat += [value for _, value in each["fields"]]
        elif not isinstance(each, list):
            flat.append(each)
    return flat


def _argument(old: Any) -> Any:
    if isinstance(old, Mapping):
        fields = [[name, value] for name, value in old.items() if name != "record"]
        return {"type": old["record"], "fields": fields}
    return [_argument(each) for each in old] if isinstance(old, list) else old


def _demonstrated(old: Row) -> Row:
    arguments = [_argument(each) for each in old["arguments"]]
    children = [_demonstrated(each) for each in old.get("children", ())]
    return {**old, "arguments": arguments, "children": children}
