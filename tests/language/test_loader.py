"""Libraries are found, and what cannot be read is reported in one sentence."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from ntp_dsl.language.diagnostics.diagnostics import NtpError, SourceError
from ntp_dsl.language.loader import diagnose, diagnose_text, load, load_text

SOUND = "library {0}\nuse tabletop\nprogram {0}(x: Object):\n    achieves clear(x)\n    clear(x)\n"


def test_an_example_is_found_by_its_name_from_anywhere(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    registry = load("block_stacking")
    assert registry.name == "block_stacking"
    assert registry["stack"].takes_list and "grasp" in registry
    assert repr(registry) == "<Registry block_stacking: 6 programs, 3 apis, 4 tasks>"
    assert set(registry.tasks) == {
        "block_stacking", "few_placements", "many_placements", "tall_towers",
    }  # fmt: skip


def test_a_folder_stands_for_the_library_it_holds(tmp_path: Path) -> None:
    (tmp_path / "mine.ntp").write_text(SOUND.format("mine"))
    assert load(tmp_path).name == load(tmp_path / "mine.ntp").name == "mine"


def test_a_library_beside_comes_before_the_standard_one(tmp_path: Path) -> None:
    (tmp_path / "mine.ntp").write_text("library mine\nuse tabletop\n")
    (tmp_path / "tabletop.ntp").write_text("library tabletop\ntype Cup\n")
    assert set(load(tmp_path / "mine.ntp").parents) == {"Cup"}


@pytest.mark.parametrize("content", [b"\xff\xfe\x00library", b"library a\0"])
def test_a_binary_file_is_no_library(tmp_path: Path, content: bytes) -> None:
    (tmp_path / "a.ntp").write_bytes(content)
    with pytest.raises(NtpError, match="not a text file"):
        load(tmp_path / "a.ntp")


def test_a_missing_library_is_reported_with_those_that_exist(tmp_path: Path) -> None:
    with pytest.raises(NtpError, match=r"no library at 'blok'.*block_stacking"):
        load("blok")
    with pytest.raises(NtpError, match="holds no .ntp file"):
        load(tmp_path)
    with pytest.raises(NtpError, match="no library at"):
        load(tmp_path / "none.ntp")


def test_libraries_that_use_one_another_in_a_circle_are_reported(tmp_path: Path) -> None:
    (tmp_path / "a.ntp").write_text("library a\nuse b\n")
    (tmp_path / "b.ntp").write_text("library b\nuse a\n")
    with pytest.raises(SourceError, match="circle: a -> b -> a"):
        load(tmp_path / "a.ntp")


def test_an_unknown_library_is_reported_with_the_nearest(tmp_path: Path) -> None:
    (tmp_path / "a.ntp").write_text("library a\nuse tabeltop\n")
    with pytest.raises(SourceError, match="did you mean 'tabletop'") as caught:
        load(tmp_path / "a.ntp")
    (mistake,) = caught.value.diagnostics
    assert (mistake.code, mistake.span.line, mistake.span.column) == ("E110", 2, 5)


def test_the_mistakes_of_all_files_come_together(tmp_path: Path) -> None:
    (tmp_path / "a.ntp").write_text("library a\nuse b\ntyp T\n")
    (tmp_path / "b.ntp").write_text("library b\nprogam p()\n")
    with pytest.raises(SourceError) as caught:
        load(tmp_path / "a.ntp")
    assert {each.span.path for each in caught.value.diagnostics} == {
        tmp_path / "a.ntp", tmp_path / "b.ntp",
    }  # fmt: skip


def test_a_text_is_a_library_that_uses_the_standard_ones() -> None:
    registry = load_text(SOUND.format("mine"))
    assert registry.name == "mine" and "pick" in registry and registry["mine"].span.path is None
    with pytest.raises(SourceError, match="<text>:2:5: .*did you mean 'tabletop'"):
        load_text(SOUND.format("mine").replace("tabletop", "tabeltop"))


def test_a_text_that_belongs_to_a_folder_uses_what_is_beside_it(tmp_path: Path) -> None:
    (tmp_path / "cups.ntp").write_text("library cups\nuse tabletop\ntype Cup is Movable\n")
    text = "library mine\nuse cups\ntype Mug is Cup\n"
    assert load_text(text, tmp_path / "mine.ntp").is_a("Mug", "Movable")
    report = diagnose_text(text.replace("Cup", "Cpu"), tmp_path / "mine.ntp")
    assert [str(each.span) for each in report.diagnostics] == [f"{tmp_path / 'mine.ntp'}:3:13"]
    assert report.registry is None and not report.is_sound
    assert not (tmp_path / "mine.ntp").exists()


def test_loading_reports_what_a_diagnosis_reports(tmp_path: Path) -> None:
    (tmp_path / "cups.ntp").write_text("library other\nuse tabletop\ntype Cup is Movable\n")
    path = tmp_path / "mine.ntp"
    path.write_text("library mine\nuse tabletop\nconstant mug: Cup\n")
    with pytest.raises(SourceError, match="declared by library 'cups', which is not used here") as caught:
        load(path)
    assert caught.value.diagnostics == diagnose(path).diagnostics
    path.write_text("library mine\nuse cups\nconstant mug: Cup\n")
    assert load(path) == diagnose(path).registry and load(path).constants["mug"] == "Cup"


def test_loading_a_library_imports_nothing_heavy() -> None:
    program = (
        "import sys; from ntp_dsl.language.loader import load; load('block_stacking')\n"
        "print(*{'torch', 'pybullet', 'mujoco', 'numpy'} & set(sys.modules))"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == ""
