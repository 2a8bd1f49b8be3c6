"""Whether what a call requires can be there when it is called: LANGUAGE.md, section 3, what is decidable."""

from __future__ import annotations

from ntp_dsl.language.names import Table


def check_contracts(table: Table) -> None:
    """Each requirement of a statement is provided before it."""
