"""The project's own sources, read as trees: what each module imports and names."""

from __future__ import annotations

import ast
from functools import cache
from pathlib import Path

ROOT = Path(__file__).parents[2]
PACKAGES = ("ntp_dsl", "kinematics")


@cache
def modules() -> dict[str, Path]:
    """Return dotted name -> file."""
    files = [file for package in PACKAGES for file in (ROOT / package).rglob("*.py")]
    return {_dotted(file): file for file in files}


def _dotted(file: Path) -> str:
    return ".".join(file.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__")


@cache
def tree(module: str) -> ast.Module:
    return ast.parse(modules()[module].read_text(encoding="utf-8"))


@cache
def imports(module: str) -> frozenset[str]:
    """Return everything that a module imports, at any place and under any condition."""
    found: set[str] = set()
    for node in ast.walk(tree(module)):
        if isinstance(node, ast.Import):
            found |= {each.name for each in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0 and node.module, f"{module} imports relatively"
            inner = {f"{node.module}.{each.name}" for each in node.names}
            found |= {name if name in modules() else node.module for name in inner}
        elif isinstance(node, ast.Call) and "import" in ast.unparse(node.func):
            found |= {each.value for each in node.args if _is_text(each)}  # import_module("x")
    return frozenset(found)


def importers(library: str) -> set[str]:
    """Return the modules that import another library, or a part of it."""
    return {module for module in modules() if any(each.split(".")[0] == library for each in imports(module))}


def _is_text(node: ast.expr) -> bool:
    return isinstance(node, ast.Constant) and isinstance(node.value, str)
