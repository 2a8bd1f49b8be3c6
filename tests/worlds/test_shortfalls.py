"""What is said of facts and conditions that do not hold."""

from __future__ import annotations

import pytest
from test_parts import fact, state

from ntp_dsl.semantics.shortfalls import why_not


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        ("wired(a)", "wired(a) does not hold"),
        ("not lit(b)", "lit(b) holds"),
        ("tidy(a)", "tidy(a) does not hold, as lit(a) does not hold and dusty(a) holds"),
        (
            "ready(a)",
            "ready(a) does not hold, as wired(a) does not hold, lit(a) does not hold and dusty(a) holds",
        ),
        ("not either(b)", "either(b) holds, as lit(b) holds"),
        ("all_lit()", "all_lit() does not hold, as lit(a) does not hold and lit(c) does not hold"),
        ("deep(a)", "deep(a) does not hold, as lit(a) does not hold"),  # `depth(a)` is asked for nothing
        ("two_lit()", "two_lit() does not hold, as at least 2 lit(l) for l in Lamp does not hold"),
        ("one_lit()", "one_lit() does not hold, as some wired(l) for l in Lamp does not hold"),
    ],
)
def test_a_fact_that_does_not_hold_is_said_with_what_is_in_its_way(asked: str, said: str) -> None:
    assert why_not(fact(asked), state(("dusty", "a"), ("lit", "b"))) == said
