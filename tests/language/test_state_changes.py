"""What is asked of the state, and that no api brings about or ends, is said."""

from __future__ import annotations

import pytest

from ntp_dsl.language.loader import diagnose_text

TEXT = """library lamps
use tabletop
type Lamp is Place
predicate lit(l: Lamp) by state
predicate dark(l: Lamp): not lit(l)
api light(l: Lamp) achieves LIGHT
api put_out(l: Lamp) achieves OUT
program go(l: Lamp):
    achieves GOAL
    light(l)
    put_out(l)
task t:
    scene: lamp: Lamp on table
    START
    run: go(lamp)
    success: GOAL
"""
ON, OFF, NOTHING = "lit(l)", "not lit(l)", "present(l)"
CASES = {  # what the apis achieve, what is asked, what holds at the start -> what is said
    (ON, OFF, "lit(L)", ""): "",
    (ON, OFF, "dark(L)", "lit"): "",
    (NOTHING, OFF, "lit(L)", ""): "it never does",
    (NOTHING, OFF, "lit(L)", "lit"): "",
    (ON, NOTHING, "dark(L)", ""): "it always will",
    (NOTHING, NOTHING, "not lit(L)", "lit"): "it always will",
    (NOTHING, NOTHING, "dark(L)", ""): "",
    (ON, "dark(l)", "dark(L)", ""): "",
}
INDEFINITE = ["lit(l) or dark(l)", "some lit(o) for o in Lamp", "lit(any)", "not (lit(l) and lit(l))"]


@pytest.mark.parametrize("case", CASES)
def test_a_fact_that_nothing_changes_is_told(case: tuple[str, str, str, str]) -> None:
    light, out, goal, start = case
    program, task = goal.replace("L", "l"), goal.replace("L", "lamp")
    text = TEXT.replace("LIGHT", light).replace("OUT", out)
    text = text.replace("achieves GOAL", f"achieves {program}").replace("success: GOAL", f"success: {task}")
    text = text.replace("    START\n", f"    initially: {start}(lamp)\n" if start else "")
    said = [each.message for each in diagnose_text(text).diagnostics if each.code == "W406"]
    assert len(said) == bool(CASES[case])
    assert all(CASES[case] in each for each in said)


@pytest.mark.parametrize("achieves", INDEFINITE)
def test_what_an_api_achieves_of_the_state_is_definite(achieves: str) -> None:
    text = TEXT.replace("LIGHT", achieves).replace("OUT", OFF).replace("    START\n", "")
    text = text.replace("achieves GOAL", "achieves lit(l)").replace("success: GOAL", "success: lit(lamp)")
    assert "E410" in {each.code for each in diagnose_text(text).diagnostics}


def test_predicates_that_are_defined_by_one_another_are_told_and_no_more() -> None:
    circle = "predicate one(l: Lamp): other(l)\npredicate other(l: Lamp): one(l)\n"
    text = TEXT.replace("LIGHT", ON).replace("OUT", OFF).replace("    START\n", "")
    text = text.replace("achieves GOAL", "achieves one(l)").replace("success: GOAL", "success: lit(lamp)")
    assert "E407" in {
        each.code for each in diagnose_text(text.replace("api light", f"{circle}api light")).diagnostics
    }


def test_an_act_that_is_never_undone_is_no_mistake() -> None:
    """An egg is cracked once: who asks that it is whole before does not ask for it to be whole again."""
    text = TEXT.replace("achieves LIGHT", "requires not lit(l) achieves lit(l)").replace("OUT", NOTHING)
    text = text.replace("    put_out(l)\n", "").replace("    START\n", "")
    text = text.replace("achieves GOAL", "achieves lit(l)").replace("success: GOAL", "success: lit(lamp)")
    assert "W406" not in {each.code for each in diagnose_text(text).diagnostics}
