"""The page in a real browser: both trees, every key, 5,000 steps, and nothing of a file executed."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from browsing import Page, browser
from PIL import Image
from trees import Node, headed, written

from ntp_dsl.cli.app import run
from ntp_dsl.semantics.observation import Observation, SceneObject
from ntp_dsl.traces.comparison.divergence import compare
from ntp_dsl.traces.decision import (
    NO_DECISION,
    Alternative,
    Answer,
    Decision,
    FactProbability,
    StatementStatus,
    Status,
)
from ntp_dsl.traces.explanation import interesting
from ntp_dsl.traces.overview import overview
from ntp_dsl.traces.page.document import NO_ROW
from ntp_dsl.traces.page.page import page
from ntp_dsl.traces.page.page_rows import page_rows
from ntp_dsl.traces.phrases import format_call
from ntp_dsl.traces.reader import read_trace
from ntp_dsl.traces.schema import ROOT, DemonstratedCall, DemonstrationReference, End, Ending, Execution
from ntp_dsl.traces.trace import Trace
from ntp_dsl.traces.writer import TraceWriter

HOSTILE = "</script><script>alert(1)</script><img src=x onerror=alert(1)>&\"'\u2028"
WELL = "run block_stacking few_placements --world kinematic --slips .3 --seed 3".split()


@pytest.fixture(scope="module")
def chromium() -> Iterator[Any]:
    with browser() as found:
        yield found


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Record a scripted and a learned episode from one seed, with other slips, and the page of both."""
    path = tmp_path_factory.mktemp("viewed")
    assert run([*WELL, "--expert", "--out", str(path / "a")]) == 0
    assert run([*WELL, "--slips", ".4", "--out", str(path / "b")]) == 0
    files = [str(path / side / "episode_00000.trace.jsonl") for side in "ab"]
    assert run(["trace", "view", *files, "--out", str(path / "both.html")]) == 0
    assert run(["trace", "view", files[1], "--out", str(path / "one.html")]) == 0
    return path


@pytest.fixture
def both(chromium: Any, folder: Path) -> Iterator[Page]:
    found = Page(chromium, folder / "both.html")
    yield found
    assert found.messages == [] and [url.split(":")[0] for url in found.requests] == ["file"]
    found.close()


def write_page(tmp_path: Path, comparison_of: tuple[Trace, Trace]) -> Path:
    path = tmp_path / "page.html"
    path.write_text(page(compare(*comparison_of), (tmp_path, tmp_path)), encoding="utf-8")
    return path


def test_both_trees_are_side_by_side(both: Page) -> None:
    heads = both.text("#heads")
    assert heads.startswith("A scripted: success") and "B learned: success" in heads
    assert "policy scripted" in heads and "policy learned" in heads
    both.press("Home")
    assert both.chosen().startswith("▾stack([(") and both.chosen().count("stack(") == 2
    assert both.page.locator(".row").count() > 10


def test_arrows_fold_unfold_and_choose(both: Page) -> None:
    both.press("Home", "ArrowDown")
    first = both.chosen()
    assert "pick_and_place" in first
    below = both.page.locator(".row").count()
    both.press("ArrowLeft")
    assert both.page.locator(".row").count() < below
    assert both.run("document.querySelector('.row.chosen').getAttribute('aria-expanded')") == "false"
    both.press("ArrowRight", "ArrowDown")
    assert "pick(" in both.chosen()
    both.press("ArrowDown", "ArrowLeft")
    assert "pick(" in both.chosen()
    both.press("End", "Home")
    assert "stack(" in both.chosen()


def test_the_chosen_call_is_shown_with_its_alternatives_and_its_statement(both: Page) -> None:
    both.press("Home", "ArrowDown")
    detail = both.text("#detail")
    for part in (
        "outcome",
        "reads",
        "why it was called",
        "why it returned",
        "callee",
        "argument 1",
        "argument 2",
        "or to return",
    ):
        assert part in detail
    assert re.search(r"block_stacking.ntp:\d+: pick_and_place\(p.item, p.support\)", detail)


def test_scopes_are_drawn_over_the_demonstration(both: Page) -> None:
    both.press("Home", "ArrowDown", "ArrowDown")
    timeline = both.text("#timeline")
    assert "demonstrated" in timeline and "hand closed" in timeline
    assert both.page.locator("#timeline .scope.side-a").count() == 3
    assert both.page.locator("#timeline .scope.side-b").count() == 3


def test_the_scrubber_moves_the_scene(both: Page) -> None:
    both.press("Home")
    assert both.text("#moment").startswith("frame 0 of")
    hand = "[...document.querySelectorAll('path.hand')].map((each) => each.getAttribute('d')).join()"
    before = both.run(hand)
    both.press("}", "}", "]")
    assert both.text("#moment").startswith("frame 21 of") and both.run(hand) != before
    both.press("{", "{", "{", "[")
    assert both.text("#moment").startswith("frame 0 of") and both.run(hand) == before
    assert both.page.locator("#scenes svg").count() == 3  # with the demonstration's


def test_what_a_call_reads_is_shown_in_the_demonstrations_scene(both: Page) -> None:
    both.press("Home", "ArrowDown")
    scope = both.run("chosenCalls()[1].scope")
    assert both.text("figcaption >> nth=0") == f"demonstration, frame {scope[0]}"
    both.press(".")
    assert both.text("figcaption >> nth=0").endswith(f"frame {scope[0] + 1}")
    both.press("<", ",")
    assert both.text("figcaption >> nth=0").endswith(f"frame {max(0, scope[0] - 10)}")
    named = both.page.locator("#scenes figure:first-child .object.named title").all_text_contents()
    assert sorted(each.split(",")[0] for each in named) == sorted(both.run("chosenCalls()[1].names"))


def test_the_chosen_call_is_played_to_its_end(both: Page) -> None:
    both.press("/", *"grasp", "Escape")
    end = both.run("Math.max(...chosenCalls().filter(Boolean).map((each) => each.end_frame))")
    both.press(" ")
    while both.run("playing.timer !== null"):
        both.page.wait_for_timeout(50)
    assert both.run("chosen.frame") == end and both.text("#play") == "play"


def test_a_scene_is_seen_from_all_sides_and_fills_the_panel(both: Page) -> None:
    drawn = "document.querySelector('#scenes svg').outerHTML"
    seen = set()
    for _ in range(3):
        both.press("v")
        seen.add(both.run(drawn))
    assert len(seen) == 3
    for count in (1, 1, 1, 3):
        both.press("z")
        assert both.page.locator("#scenes figure").count() == count
        panel, scenes = (both.page.locator(each).bounding_box() for each in ("#side", "#scenes"))
        assert count == 3 or scenes["height"] > 0.8 * panel["height"]


def test_search_finds_calls_by_name_and_object(both: Page) -> None:
    both.press("Home", "/", *"release")
    assert re.fullmatch(r"1 of \d+", both.text("#found")) and "release()" in both.chosen()
    both.press("Enter")
    assert both.text("#found").startswith("2 of")
    assert both.page.locator("mark").count() > 1
    both.press("Escape", "ArrowUp")
    assert "release" not in both.chosen()


def test_the_keys_are_listed_and_the_theme_changes(both: Page) -> None:
    both.press("?")
    assert both.page.locator("#keys").is_visible()
    both.press("Escape")
    assert not both.page.locator("#keys").is_visible()
    colour = "getComputedStyle(document.body).backgroundColor"
    before = both.run(colour)
    both.press("t")
    assert both.run(colour) != before
    both.press("t")
    assert both.run(colour) == before


def test_everything_can_be_reached_without_a_mouse(both: Page) -> None:
    reached = set()
    for _ in range(24):
        both.press("Tab")
        reached.add(both.run("document.activeElement.id"))
    tools = {"search", "previous", "next", "theme", "help", "play", "view", "zoom"}
    assert tools | {"tree", "detail", "shown", "frame"} <= reached


@pytest.mark.parametrize("theme", ["light", "dark"])
def test_text_has_enough_contrast(chromium: Any, folder: Path, theme: str) -> None:
    """All text has the contrast that WCAG requires, 4.5 to 1."""
    found = Page(chromium, folder / "both.html", theme)
    found.press("Home", "ArrowDown")
    ratios = found.run(CONTRASTS)
    found.close()
    assert len(ratios) > 50
    assert [each for each in ratios if each["ratio"] < 4.5] == []


def test_one_trace_is_shown_alone(chromium: Any, folder: Path) -> None:
    found = Page(chromium, folder / "one.html")
    assert found.page.locator(".mark").count() == 0 and not found.page.locator("#next").is_visible()
    assert found.text("#summary") == "learned: success" and found.messages == []
    found.close()


def test_a_failed_episode_opens_where_one_would_look_with_why(
    chromium: Any, folder: Path, tmp_path: Path
) -> None:
    shown = read_trace(folder / "a" / "episode_00000.trace.jsonl")
    item = next(call for call in shown.calls if call.name == "pick").arguments[0]
    forced = f"pick({item}): holding({item})=true"
    assert run([*WELL, "--expert", "--inject", forced, "--out", str(tmp_path)]) == 1
    file = tmp_path / "episode_00000.trace.jsonl"
    assert run(["trace", "view", str(file), "--out", str(tmp_path / "failed.html")]) == 0
    trace = read_trace(file)
    asked = interesting(trace)
    found = Page(chromium, tmp_path / "failed.html")
    assert asked is not None and asked.id > 0 and format_call(asked) in found.chosen()
    assert found.text("#overview") == " ".join(overview(trace)[1:]) != ""
    found.close()


def diverging(count: int) -> tuple[Trace, Trace]:
    """Return two traces that diverge in the middle."""
    run_a = Node("run", "run", kids=[Node("program", "build")])
    for number in range(count // 5):
        obj, scope = f"block_{number}", (number, number + 5)
        kids = [Node("api", f"step_{n}", (obj,), None, "achieved") for n in range(4)]
        run_a.kids[0].kids.append(Node("program", "part", (obj,), scope, "done", kids))
    run_b = run_a.copy()
    run_b.kids[0].kids[count // 10].kids[2].name = "other"
    return written(run_a), written(run_b)


def test_five_thousand_steps_open_at_the_divergence_and_move_at_once(chromium: Any, tmp_path: Path) -> None:
    found = Page(chromium, write_page(tmp_path, diverging(5000)))
    assert "step_2(" in found.chosen() and found.messages == []
    row, tree = (found.page.locator(each).bounding_box() for each in (".row.chosen", "#tree"))
    assert tree["y"] <= row["y"] and row["y"] + row["height"] <= tree["y"] + tree["height"]
    assert "other(" in found.text("#detail .card:last-child")
    assert found.page.locator(".row").count() < 100
    took = found.run(
        """() => { const start = performance.now();
        for (let n = 0; n < 20; n += 1) { step(1); jump(-1); updateVisible(); }
        return (performance.now() - start) / 20; }"""
    )
    assert took < 250  # [ms] for three changes of the page, on a machine that may be busy
    found.press("End")
    assert "part(block_999)" in found.chosen()
    found.close()


def test_a_divergence_is_shown_with_both_calls_that_diverged(chromium: Any, tmp_path: Path) -> None:
    """Also where the alignment matches the reference's call with a later one of the other trace."""
    run_a = Node("run", "run", kids=[Node("program", "build")])
    run_a.kids[0].kids = [Node("api", "step", (f"block_{n}",), None, "achieved") for n in range(4)]
    run_b = run_a.copy()
    run_b.kids[0].kids.insert(1, Node("api", "detour", (), None, "achieved"))
    found = Page(chromium, write_page(tmp_path, (written(run_a), written(run_b))))
    cards = [found.text(f"#detail .card >> nth={side}") for side in (0, 1)]
    assert cards[0].startswith("A step(block_1)") and cards[1].startswith("B detour()")
    assert found.chosen() == "+ detour() ✓"
    assert found.page.locator(".row.changed").count() == 0
    found.close()


def test_the_page_says_which_facts_were_seen_wrongly(chromium: Any, tmp_path: Path) -> None:
    path = tmp_path / "a.jsonl"
    facts = (FactProbability("on(a, b)", 0.42, True), FactProbability("clear(a)", 1.0, True))
    due = StatementStatus(line=7, status=Status.DUE, callee="put", arguments=("a", "b"), lacks=("clear(b)",))
    with path.open("w", encoding="utf-8") as stream:
        writer = TraceWriter(stream)
        obj = SceneObject("a", "Block", (0.05, 0.05, 0.05))
        writer.header(headed(objects=(obj,)))
        seen = writer.state(Observation((obj,), {"a": (0.5, 0.0, 0.0)}, (0.0, 0.0, 0.5), False))
        root = writer.call(ROOT, "program", "go", (), None, 0, seen, NO_DECISION)
        made = writer.call(
            root, "api", "put", ("a",), None, 0, seen, Decision(facts=facts, statements=(due,))
        )
        writer.returned(made, "achieved", 1)
        writer.returned(root, "done", 1)
        writer.end(End(ending=Ending.DONE, success=False, verdict="on(a, b) does not hold"))
    trace = read_trace(path)
    found = Page(chromium, write_page(tmp_path, (trace, trace)))
    assert found.text("#summary").endswith("failed: on(a, b) does not hold")
    found.press("ArrowDown")
    assert "line 7 put(a, b) lacks clear(b)" in found.text("#detail")
    assert found.text("#detail tr.bad") == "on(a, b)\t42%\tyes"
    assert found.text("#detail summary") == "1 that held"
    found.close()


def test_n_and_p_go_from_one_divergence_to_the_next(chromium: Any, tmp_path: Path) -> None:
    a, b = diverging(100)
    found = Page(chromium, write_page(tmp_path, (a, b)))
    count = len({row for each in compare(a, b).divergences if (row := each.a) is not None})
    assert count == 1 and "step_2(" in found.chosen()
    found.press("Home", "n")
    assert "step_2(" in found.chosen()
    found.press("End", "p")
    assert "step_2(" in found.chosen()
    assert "≠ program" in found.text("#detail")
    found.close()


def hostile(path: Path) -> Trace:
    """Write a trace in which every text is an attack."""
    with path.open("w", encoding="utf-8") as stream:
        writer = TraceWriter(stream)
        obj = SceneObject(HOSTILE, HOSTILE, (0.05, 0.05, 0.05))
        child = DemonstratedCall(name=HOSTILE, arguments=(HOSTILE,), scope=(0, 5), done=True)
        whole = DemonstratedCall(name=HOSTILE, arguments=(), scope=(0, 9), done=True, children=[child])
        writer.header(
            headed(
                task=HOSTILE,
                library=HOSTILE,
                world=HOSTILE,
                objects=(obj,),
                sources={HOSTILE: HOSTILE},
                demonstration=DemonstrationReference(file="../x", frames=9, calls=whole),
            )
        )
        seen = Observation((obj,), {HOSTILE: (0.5, 0, 0)}, (0, 0, 1), False)
        likely = (Alternative(HOSTILE, 1.0),)
        decision = Decision(
            source=HOSTILE,
            probability=0.5,
            callees=likely,
            arguments=(likely,),
            scopes=(Alternative((0, 9), 1.0),),
            answer=Answer(HOSTILE, arguments=(HOSTILE,)),
        )
        root = writer.call(ROOT, "program", HOSTILE, (HOSTILE,), (0, 9), 0, writer.state(seen), decision)
        for name in ("../../secret.jpg", "/etc/hostname", "http://example.org/a.jpg", "\0", "not.jpg"):
            writer.picture(0, name)
        execution = Execution(evidence={HOSTILE: HOSTILE}, disturbances=(HOSTILE,), solver=HOSTILE)
        writer.returned(root, "done", 1, execution=execution)
        writer.end(End(ending=Ending.DONE, reason=HOSTILE, verdict=HOSTILE))
    return read_trace(path)


def test_nothing_of_a_hostile_file_is_executed(chromium: Any, tmp_path: Path) -> None:
    folder = tmp_path / "in" / "side"
    folder.mkdir(parents=True)
    Image.new("RGB", (4, 4)).save(tmp_path / "secret.jpg")
    (folder / "not.jpg").write_text("<svg onload=alert(1)>")
    trace = hostile(folder / "a.jsonl")
    text = page(compare(trace, hostile(folder / "b.jsonl")), (folder, folder))
    assert "<img" not in text and text.count("</script>") == 2 and "data:image" not in text
    path = tmp_path / "hostile.html"
    path.write_text(text, encoding="utf-8")
    found = Page(chromium, path)
    found.press("Home", "/", *"alert", "Enter", "Escape", "]", "n")
    assert found.messages == [] and len(found.requests) == 1
    assert found.run("document.scripts.length") == 2 and found.run("document.images.length") == 0
    assert "onerror" in found.text("#tree")
    found.close()


def test_a_page_is_forbidden_the_network_and_any_other_script(both: Page) -> None:
    blocked = both.run(
        """async () => { const names = [];
        document.addEventListener("securitypolicyviolation", (event) => names.push(event.effectiveDirective));
        await fetch("http://127.0.0.1:9/").catch(() => 0);
        const script = document.createElement("script"); script.textContent = "window.ran = true";
        document.body.append(script);
        const image = new Image(); image.src = "http://127.0.0.1:9/a.png"; document.body.append(image);
        await new Promise((done) => setTimeout(done, 200));
        return [names.sort(), window.ran === true]; }"""
    )
    assert blocked == [["connect-src", "img-src", "script-src-elem"], False]
    both.messages.clear()  # the browser reports each
    both.requests[:] = both.requests[:1]


def test_camera_pictures_are_in_the_page(chromium: Any, tmp_path: Path) -> None:
    frames = tmp_path / "frames"
    frames.mkdir()
    path = tmp_path / "a.jsonl"
    obj = SceneObject("a", "Block", (0.05, 0.05, 0.05))
    with path.open("w", encoding="utf-8") as stream:
        writer = TraceWriter(stream)
        writer.header(headed(objects=(obj,)))
        for number in range(4):
            Image.new("RGB", (40, 30), (60 * number, 0, 0)).save(frames / f"{number}.jpg")
            seen = Observation((obj,), {"a": (0.1 * number, 0.0, 0.0)}, (0.0, 0.0, 0.5), False)
            writer.picture(writer.frame(0.1 * number, seen), f"frames/{number}.jpg")
        root = writer.call(ROOT, "program", "go", (), None, 0, writer.state(seen), NO_DECISION)
        writer.returned(root, "done", 4)
    trace = read_trace(path)
    found = Page(chromium, write_page(tmp_path, (trace, trace)))
    alt = "document.images[0].alt"
    assert found.run(alt) == "camera picture at frame 0"
    found.press("]", "]")
    assert found.run(alt) == "camera picture at frame 2"
    assert found.run("document.images[0].naturalWidth") == 40 and found.messages == []
    found.close()


def test_rows_of_a_page_nest_and_mark_differences() -> None:
    rows = page_rows(compare(*diverging(100)))
    assert [row.end for row in rows][:2] == [len(rows), 6]
    for number, row in enumerate(rows):
        assert row.parent < number < row.end <= len(rows)
        assert row.parent == NO_ROW or rows[row.parent].depth == row.depth - 1
    marks = [row.mark for row in rows]
    assert (marks.count("only a"), marks.count("only b")) == (1, 1)
    assert not rows[0].unchanged and rows[1].unchanged


def test_json_names_the_file_of_the_page(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "a.html"
    words = ["trace", "view", str(folder / "a" / "episode_00000.trace.jsonl"), "--out", str(out), "--json"]
    assert run(words) == 0
    assert json.loads(capsys.readouterr().out) == {"file": str(out), "bytes": out.stat().st_size}


# For each element with text of its own: the contrast of its colour with the background.
CONTRASTS = """() => {
  const canvas = document.createElement("canvas").getContext("2d", { willReadFrequently: true });
  const rgb = (colours) => { canvas.clearRect(0, 0, 1, 1);
    for (const colour of colours) { canvas.fillStyle = colour; canvas.fillRect(0, 0, 1, 1); }
    return [...canvas.getImageData(0, 0, 1, 1).data]; };
  const light = ([r, g, b]) => [r, g, b].map((c) => c / 255)
    .map((c) => (c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4))
    .reduce((sum, c, place) => sum + c * [0.2126, 0.7152, 0.0722][place], 0);
  const found = [];
  for (const each of document.querySelectorAll("body *")) {
    const own = [...each.childNodes].some((node) => node.nodeType === 3 && node.textContent.trim());
    if (!own || each.closest("script, svg, dialog") || !each.checkVisibility()) continue;
    const behind = [];
    for (let box = each; box; box = box.parentElement) behind.unshift(getComputedStyle(box).backgroundColor);
    const ground = rgb(["white", ...behind]);
    const colour = rgb(["white", ...behind, getComputedStyle(each).color]);
    const [dark, bright] = [light(ground), light(colour)].sort((one, other) => one - other);
    const text = `${each.className}: ${each.textContent.slice(0, 30)}`;
    found.push({ ratio: (bright + 0.05) / (dark + 0.05), text });
  }
  return found;
}"""
