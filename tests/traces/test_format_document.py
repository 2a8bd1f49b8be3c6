"""The document of the format names every event, field and member that traces are written with."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Iterator
from enum import StrEnum
from pathlib import Path

import msgspec
import pytest

from ntp_dsl.semantics.observation import Record, SceneObject
from ntp_dsl.traces.decision import Answer, Decision, FactProbability
from ntp_dsl.traces.reader import EVENTS
from ntp_dsl.traces.schema import (
    FORMAT,
    VERSION,
    Attribution,
    CallKind,
    DemonstratedCall,
    DemonstrationReference,
    Ending,
    Execution,
    PolicyKind,
)
from ntp_dsl.worlds.protocol import Disturbances

TEXT = (Path(__file__).parents[2] / "docs" / "traces.md").read_text(encoding="utf-8")
NAMES = set(re.findall(r"`(\w+)`", TEXT))
STRUCTS = (
    *EVENTS.values(),
    Decision,
    FactProbability,
    Answer,
    Execution,
    DemonstrationReference,
    DemonstratedCall,
)
DATACLASSES = (SceneObject, Disturbances)


def fields() -> Iterator[str]:
    for struct in STRUCTS:
        yield from (field.encode_name for field in msgspec.structs.fields(struct))
    for each in DATACLASSES:
        yield from (field.name for field in dataclasses.fields(each))


@pytest.mark.parametrize("name", sorted(set(fields())))
def test_every_field_is_documented(name: str) -> None:
    assert name in NAMES


@pytest.mark.parametrize("event", EVENTS)
def test_every_event_has_a_paragraph_that_names_its_fields(event: str) -> None:
    start = re.search(rf"^\*\*{event}\*\*", TEXT, re.MULTILINE)
    assert start is not None
    end = re.search(r"^(\*\*|##)", TEXT[start.end() :], re.MULTILINE)
    assert end is not None
    paragraph = TEXT[start.end() : start.end() + end.start()]
    names = {field.encode_name for field in msgspec.structs.fields(EVENTS[event])}
    assert names <= set(re.findall(r"`(\w+)`", paragraph))


@pytest.mark.parametrize("members", [PolicyKind, CallKind, Ending, Attribution])
def test_every_member_is_documented(members: type[StrEnum]) -> None:
    assert {each.value for each in members} <= NAMES


def test_the_version_and_the_encoding_of_records_are_the_present_ones() -> None:
    assert f"| `{FORMAT}`, {VERSION} |" in TEXT
    (example,) = re.findall(r'\{"type": "Placement".*?\]\]\}', TEXT, re.DOTALL)
    record = msgspec.json.decode(example.replace("\n", " "), type=Record)
    assert record == Record("Placement", (("item", "block_1"), ("support", "table")))
