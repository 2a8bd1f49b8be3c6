"""From a file to its text or its XML tree, within limits on size and depth; a fault names file and line."""

import xml.etree.ElementTree as ElementTree
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from xml.parsers import expat

from kinematics.errors import UnusableRobot

Element = ElementTree.Element

MOST_ELEMENTS = 20_000  # of an XML file; a Panda has 400
MOST_DEPTH = 50  # of its nesting


@dataclass(frozen=True)
class XmlTree:
    """The elements of an XML file, without their text, and the line of each."""

    path: Path
    root: Element
    lines: Mapping[Element, int]

    def place_of(self, element: Element) -> str:
        """Return file and line, for a message."""
        return f"{self.path}, line {self.lines[element]}"


def exists(path: Path) -> bool:
    """Return whether there is such a file; a path that no system accepts has none."""
    try:
        return path.is_file()
    except (OSError, ValueError):
        return False


def read_text(path: Path, most_bytes: int) -> str:
    """Return the text of a UTF-8 file; raise `UnusableRobot` if it is too large, or not text."""
    try:
        with path.open("rb") as file:
            content = file.read(most_bytes + 1)
    except OSError as unexpected:
        raise UnusableRobot(f"{path} cannot be read: {unexpected.strerror}") from unexpected
    if len(content) > most_bytes:
        raise UnusableRobot(f"{path} has more than {most_bytes:,} bytes; is it the right file?")
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError as unexpected:
        line = content.count(b"\n", 0, unexpected.start) + 1
        raise UnusableRobot(
            f"{path}, line {line}: it is not in UTF-8; save it in that encoding"
        ) from unexpected
    if "\0" in text:
        line = text.count("\n", 0, text.index("\0")) + 1
        raise UnusableRobot(f"{path}, line {line}: it has a NUL byte; is it a text file?")
    return text


def read_xml(path: Path, most_bytes: int) -> XmlTree:
    """Return the elements of an XML file; raise `UnusableRobot` if it is not XML, or beyond a limit.

    Prefixes of names are kept as they are, declared or not.
    """
    text = read_text(path, most_bytes)
    builder, lines = ElementTree.TreeBuilder(), dict[Element, int]()
    parser = expat.ParserCreate("utf-8")
    open_elements: list[str] = []

    def start(tag: str, attributes: dict[str, str]) -> None:
        open_elements.append(tag)
        place = f"{path}, line {parser.CurrentLineNumber}"
        if len(open_elements) > MOST_DEPTH:
            raise UnusableRobot(f"{place}: elements are nested more than {MOST_DEPTH} deep")
        if len(lines) == MOST_ELEMENTS:
            raise UnusableRobot(f"{place}: there are more than {MOST_ELEMENTS:,} elements")
        lines[builder.start(tag, attributes)] = parser.CurrentLineNumber

    def end(tag: str) -> None:
        open_elements.pop()
        builder.end(tag)

    def entity(*_: object) -> None:
        raise UnusableRobot(f"{path}, line {parser.CurrentLineNumber}: it declares an entity; write it out")

    parser.StartElementHandler, parser.EndElementHandler = start, end
    parser.EntityDeclHandler = entity
    try:
        parser.Parse(text, True)
    except expat.ExpatError as unexpected:
        fault = expat.errors.messages.get(unexpected.code, "unknown error")
        raise UnusableRobot(f"{path}, line {unexpected.lineno}: this is not XML: {fault}") from unexpected
    return XmlTree(path, builder.close(), lines)
