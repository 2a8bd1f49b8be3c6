"""From text of unknown origin to typed records; whatever is wrong with it is one printable line."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Annotated, TypeVar

import msgspec
from msgspec import Meta

from ntp_dsl.common.text import shortened

Decoded = TypeVar("Decoded")

MAX_COUNT = 10**9  # of frames, calls, episodes and the like
Count = Annotated[int, Meta(ge=0, le=MAX_COUNT)]


class Unreadable(ValueError):
    """The text does not hold the expected record; the message is one printable line."""


@contextmanager
def decoding() -> Iterator[None]:
    """Turn whatever malformed data raise when they are decoded or converted into `Unreadable`."""
    try:
        yield
    except RecursionError as error:
        raise Unreadable("it is nested too deeply") from error
    except KeyError as error:
        raise Unreadable(shortened(f"it lacks {error}")) from error
    except (ValueError, TypeError, AttributeError, IndexError, ArithmeticError) as error:
        raise Unreadable(shortened(error)) from error


def decode(text: bytes | str, expected: type[Decoded]) -> Decoded:
    """Return the record that JSON holds. Raises `Unreadable`, with the place of what is wrong."""
    with decoding():
        return msgspec.json.decode(text, type=expected)
