"""The command `ntp`. One module a command; a module is imported when its command is called."""

from ntp_dsl.cli.app import main

__all__ = ["main"]
