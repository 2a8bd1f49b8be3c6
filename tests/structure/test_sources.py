"""What no file of the project may contain."""

from __future__ import annotations

import ast
import re
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest
from sources import ROOT, imports, modules, tree

from ntp_dsl.common.resources import examples_folder, library_folder
from ntp_dsl.language.loader import load

UNSAFE = {"pickle", "cPickle", "dill", "cloudpickle", "joblib", "shelve", "marshal"}
EVERY_MODULE = sorted(modules())
CORE = [name for name in EVERY_MODULE if name.startswith("ntp_dsl.core")]
LIBRARIES = sorted([*library_folder().glob("*.ntp"), *examples_folder().glob("*/*.ntp")])


@pytest.mark.parametrize("module", EVERY_MODULE)
def test_nothing_that_is_read_can_run(module: str) -> None:
    assert not UNSAFE & {name.split(".")[0] for name in imports(module)}
    calls = [node for node in ast.walk(tree(module)) if isinstance(node, ast.Call)]
    names = {ast.unparse(call.func) for call in calls}
    assert not names & {"eval", "exec", "torch.load", "torch.save", "np.load"}
    options = {keyword.arg for call in calls for keyword in call.keywords}
    assert "allow_pickle" not in options


def declared_names() -> set[str]:
    """Return the programs, apis, constants and objects of the shipped libraries."""
    names: set[str] = set()
    for path in LIBRARIES:
        registry = load(path)
        names |= {*registry.programs, *registry.apis, *registry.constants, *registry.tasks}
        names |= {group.name for task in registry.tasks.values() for group in task.scene}
    return names


def words_of(text: str) -> set[str]:
    return set(re.findall(r"[A-Za-z_]+[A-Za-z]", text))


def words_and_names(module: str) -> Iterator[str]:
    """Yield the words of a module's texts (except docstrings) and the names that it defines or uses.

    Attributes are left out: `torch.stack` and an observation's `gripper` are not programs.
    """
    bare = {id(node.value) for node in ast.walk(tree(module)) if isinstance(node, ast.Expr)}
    for node in ast.walk(tree(module)):
        match node:
            case ast.Constant(value=str() as text) if id(node) not in bare:
                yield from words_of(text)
            case ast.Name(id=name) | ast.arg(arg=name) | ast.keyword(arg=str() as name):
                yield name
            case ast.FunctionDef(name=name) | ast.ClassDef(name=name):
                yield name


# English words that are also programs: the core may use them in their English meaning.
PLAIN_WORDS = {"place", "gripper", "clear"}


@pytest.mark.parametrize("module", CORE)
def test_the_core_knows_nothing_of_the_libraries_by_name(module: str) -> None:
    names = declared_names()
    assert {"pick_and_place", "move_to", "table", "stack"} <= names
    used = set(words_and_names(module)) - PLAIN_WORDS
    assert used & names == set()
    assert not any(re.fullmatch(r"(block|cube)_?\d*", word, re.IGNORECASE) for word in used)
    texts = [n.value for n in ast.walk(tree(module)) if isinstance(n, ast.Constant)]
    assert not names & {text for text in texts if isinstance(text, str)}


def tracked_texts() -> list[Path]:
    listing = ["git", "ls-files", "--cached", "--others", "--exclude-standard"]
    done = subprocess.run(listing, cwd=ROOT, capture_output=True, text=True, check=False)
    paths = [ROOT / line for line in done.stdout.splitlines()]
    kinds = {
        ".py",
        ".md",
        ".ntp",
        ".lark",
        ".toml",
        ".txt",
        ".json",
        ".yml",
        ".yaml",
        ".cff",
        "",
        ".cfg",
        ".sh",
    }
    return [path for path in paths if path.suffix in kinds and path.is_file()]


HOMES = "home root Users work tmp opt mnt".split()
ABSOLUTE = re.compile(rf"(?<![\w.~/$}}-])/(?:{'|'.join(HOMES)})/[\w.-]+")


def test_no_file_names_a_place_on_one_machine() -> None:
    found = {}
    for path in tracked_texts():
        if path != Path(__file__):
            text = path.read_text(encoding="utf-8", errors="replace")
            if matches := ABSOLUTE.findall(text):
                found[path.relative_to(ROOT)] = matches
    assert found == {}


INSTALLING = (
    "Makefile", "pyproject.toml", "constraints.txt", ".ci/run", ".github/workflows/test.yml",
    ".pre-commit-config.yaml",
)  # fmt: skip


@pytest.mark.parametrize("name", INSTALLING)
def test_where_packages_come_from_is_the_machines_own_business(name: str) -> None:
    assert not re.search(r"index-url|find-links|trusted-host|https?://", (ROOT / name).read_text())


def test_every_module_has_a_docstring() -> None:
    written = [name for name, file in modules().items() if file.stat().st_size]
    assert [name for name in written if not ast.get_docstring(tree(name))] == []
