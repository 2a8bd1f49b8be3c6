"""`ntp new`: a new domain from a template."""

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
    name: Annotated[str, typer.Argument(help="Name of the library: letters, digits and underscores.")],
    out: Annotated[Path, typer.Option(help="Parent folder.")] = Path("."),
    python: Annotated[bool, typer.Option("--python", help="Write the expert as a Python function.")] = False,
) -> int:
    """Create a folder with a small domain that can be checked and run as it is.

    Its README lists the next commands. Existing files are not overwritten.

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
        valid = re.sub(r"\W+", "_", name, flags=re.ASCII).strip("_")
        example = f"; for example: {valid}" if re.fullmatch(r"[A-Za-z_]\w*", valid, re.ASCII) else ""
        raise NtpError(f"'{name}' is not a valid library name: use letters, digits and underscores{example}")
    if name in RESERVED:
        raise NtpError(f"'{name}' is a keyword of the language; choose another name")
    if (library_folder() / f"{name}.ntp").exists():
        raise NtpError(f"'{name}' is a standard library, which the new one uses; choose another name")
