"""`ntp new`: a domain to start from."""

from __future__ import annotations

import re
import shlex
from pathlib import Path
from string import Template
from typing import Annotated

import typer

from ntp_dsl.common.files import written_whole
from ntp_dsl.common.resources import library_folder, templates_folder
from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.language.parsing.term_builder import RESERVED


def command(
    name: Annotated[str, typer.Argument(help="Of the library: letters, digits and underscores.")],
    out: Annotated[Path, typer.Option(help="The folder to put it in.")] = Path("."),
    python: Annotated[
        bool, typer.Option("--python", help="With an expert that is a function in Python.")
    ] = False,
) -> int:
    """Make a folder with a small domain that checks, records and trains as it stands.

    Its README has the lines to type next. Nothing that exists is written over.

    Example: ntp new pairs --out domains
    """
    _check_name(name)
    folder = out / name
    if folder.exists():
        raise NtpError(f"'{folder}' exists already: choose another name, or another folder with --out")
    kind, quoted = "python" if python else "plain", shlex.quote(str(folder))
    for template in sorted((templates_folder() / kind).iterdir()):
        path = folder / template.name.replace("NAME", name).removesuffix(".template")
        text = Template(template.read_text(encoding="utf-8")).substitute(name=name, folder=quoted)
        with written_whole(path) as partial:
            partial.write_text(text, encoding="utf-8")
        print(f"wrote {path}")
    print(f"next: ntp check {quoted}")
    return 0


def _check_name(name: str) -> None:
    if not re.fullmatch(r"[A-Za-z_][A-Za-z0-9_]*", name):
        meant = re.sub(r"\W+", "_", name, flags=re.ASCII).strip("_")
        guess = f"; for example: {meant}" if re.fullmatch(r"[A-Za-z_]\w*", meant, re.ASCII) else ""
        raise NtpError(f"'{name}' cannot be a library's name: letters, digits and underscores can{guess}")
    if name in RESERVED:
        raise NtpError(f"'{name}' is a word of the language; nothing else can be called that")
    if (library_folder() / f"{name}.ntp").exists():
        raise NtpError(f"'{name}' is a standard library, which the new one uses; choose another name")
