"""Mutations of valid files: of their bytes, of their JSON, and of their JSON's values."""

from __future__ import annotations

import json
from random import Random
from typing import Any

NAMES = [
    "block_0", "table", "", "\x1b[2J", "\n", "a\0b", "../../x", "/dev/zero", "é", "\ud800", "\u202e",
    "a" * 5000,
]  # fmt: skip
NUMBERS = [
    0, -1, 1, 2**31, 2**63, 2**64, 10**9, 10**400, 1e308, -1e308, 1e-320, 0.5, float("nan"), float("inf"),
]  # fmt: skip
VALUES = [None, True, False, [], {}, [[1]], [[]], {"": ""}, *NAMES, *NUMBERS]
DEEP = ["[" * 100_000, '{"a":' * 100_000, "[" * 900 + "]" * 900, '{"a":' * 300 + "1" + "}" * 300]
MARK = '"a place for what json.dumps cannot write"'


def mutated_json(chance: Random, text: str) -> bytes:
    """Return a document with a few values, keys or bytes changed; most results are still JSON."""
    if chance.random() < 0.2:
        return mutated_bytes(chance, text.encode())
    document = json.loads(text)
    for _ in range(chance.choice((1, 1, 1, 2, 4))):
        document = _changed(chance, document)
    written = json.dumps(document, ensure_ascii=chance.random() < 0.5)
    if MARK in written:
        written = written.replace(MARK, chance.choice(DEEP))
    if chance.random() < 0.1 and '"' in written:
        written = _with_repeated_key(chance, written)
    return written.encode("utf-8", "surrogatepass")


def mutated_bytes(chance: Random, content: bytes) -> bytes:
    """Return bytes with some changed, removed, inserted, repeated, or all after a place cut off."""
    spoilt = bytearray(content)
    for _ in range(chance.choice((1, 1, 2, 8))):
        at, length = chance.randrange(len(spoilt) + 1), chance.choice((1, 1, 4, 100))
        match chance.randrange(6):
            case 0:
                spoilt[at : at + length] = chance.randbytes(length)
            case 1:
                del spoilt[at : at + length]
            case 2:
                spoilt[at:at] = chance.randbytes(length)
            case 3:
                spoilt[at:at] = spoilt[at : at + length] * chance.choice((1, 50))
            case 4:
                del spoilt[at:]
            case 5 if at < len(spoilt):
                spoilt[at] ^= 1 << chance.randrange(8)
    return bytes(spoilt)


def _changed(chance: Random, value: Any) -> Any:
    """Return a value with one somewhere in it changed; deep values are as probable as shallow ones."""
    if isinstance(value, dict | list) and value and chance.random() < 0.85:
        return _changed_within(chance, value)
    if isinstance(value, bool | int | float) and chance.random() < 0.5:
        return chance.choice(NUMBERS)
    if isinstance(value, str) and chance.random() < 0.5:
        return chance.choice(NAMES)
    if chance.random() < 0.05:
        return json.loads(MARK)
    return chance.choice(VALUES)


def _changed_within(chance: Random, value: Any) -> Any:
    keys = list(value) if isinstance(value, dict) else list(range(len(value)))
    key = chance.choice(keys)
    copy = value.copy()
    action = chance.random()
    if action < 0.8:
        copy[key] = _changed(chance, value[key])
    elif action < 0.87:
        del copy[key]
    elif action < 0.94:
        copy[key] = value[chance.choice(keys)]
    elif isinstance(copy, dict):
        copy[chance.choice(NAMES)] = copy.pop(key)
    else:
        copy *= chance.choice((2, 50))
    return copy


def _with_repeated_key(chance: Random, text: str) -> str:
    """Give an object one of its keys twice."""
    keys = [at for at, letter in enumerate(text) if letter == "{"]
    if not keys:
        return text
    at = chance.choice(keys) + 1
    end = text.find(":", at)
    key = text[at:end] if end > 0 else '"name"'
    return f"{text[:at]}{key}: {json.dumps(chance.choice(VALUES))}, {text[at:]}"
