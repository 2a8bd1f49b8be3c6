"""Goals as text: what is written is read back, and anything else is one sentence with its line."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from ntp_dsl.api import draw
from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.language.loader import load, load_text
from ntp_dsl.language.registry import Parameter, Registry
from ntp_dsl.semantics.observation import Record, SceneObject
from ntp_dsl.tasks.goal_text import BASE_UNITS, format_lists, read_lists

TEXT = """
library parcels
use tabletop
type Parcel is Movable
enum Care: gentle, rough, upside_down
record Order(parcel: Parcel, to: Place, gap: length, turn: angle, after: time, push: force, load: mass,
    share: number, care: Care)
record Near(parcel: Parcel, gap: length in 2 cm .. 8 cm)
predicate sent(o: Order): on(o.parcel, o.to)
program send(orders: list[Order], nears: list[Near], kinds: list[Care], rest: list[Parcel]):
    achieves all on(o.parcel, o.to) for o in orders
    for o in orders:
        pick_and_place(o.parcel, o.to)
"""
PARCELS = load_text(TEXT)
OBJECTS = tuple(SceneObject(f"parcel_{index}", "Parcel", (0.05, 0.05, 0.05)) for index in range(4))
NUMBERS = st.one_of(
    st.integers(-9_999, 9_999).map(float),
    st.integers(-999_999, 999_999).map(lambda each: each / 1e5),
    st.sampled_from([0.0, 1e-05, -2.5e-07, 123456.0, 1e10]),
)


def values(registry: Registry, field: Parameter) -> st.SearchStrategy[Any]:
    if field.type in registry.enums:
        return st.sampled_from(registry.enums[field.type])
    if field.type in registry.parents:
        places = ["table"] if field.type == "Place" else []
        return st.sampled_from([*(obj.name for obj in OBJECTS), *places])
    if field.low is not None and field.high is not None:
        return st.floats(field.low, field.high).map(lambda each: float(f"{each:.6g}"))
    return NUMBERS


def elements(registry: Registry, parameter: Parameter) -> st.SearchStrategy[Any]:
    if parameter.type not in registry.records:
        return values(registry, parameter)
    fields = registry.records[parameter.type]
    each = st.tuples(*(values(registry, field) for field in fields))
    names = [field.name for field in fields]
    return each.map(lambda found: Record(parameter.type, tuple(zip(names, found, strict=True))))


def read(path: Path, text: str | bytes, registry: Registry = PARCELS) -> Any:
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return read_lists(path, registry, registry.programs["send"], OBJECTS)


SEND = PARCELS.programs["send"]
LISTS = st.tuples(
    *(
        st.lists(elements(PARCELS, each), max_size=5 if each.type in PARCELS.records else 0).map(tuple)
        for each in SEND.parameters
    )
)


def test_lists_of_objects_and_members_are_read_back(tmp_path: Path) -> None:
    lists = ((), (), ("gentle", "rough"), ("parcel_2", "parcel_0"))
    found = read(tmp_path / "goal.txt", format_lists(PARCELS, SEND, lists))
    assert tuple(found.values()) == lists


@settings(max_examples=100, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(LISTS)
def test_what_is_written_is_read_back(tmp_path: Path, lists: tuple[Any, ...]) -> None:
    text = format_lists(PARCELS, SEND, lists)
    found = read(tmp_path / "goal.txt", text)
    assert list(found) == [each.name for each in SEND.parameters]
    for got, wanted in zip(found.values(), lists, strict=True):
        assert [names_in(each) for each in got] == [names_in(each) for each in wanted]
        assert numbers_in(got) == pytest.approx(numbers_in(wanted), rel=1e-5)
    assert format_lists(PARCELS, SEND, tuple(found.values())) == text


def names_in(element: Record | str) -> list[str]:
    return [v for _, v in element.fields if isinstance(v, str)] if isinstance(element, Record) else [element]


def numbers_in(lists: tuple[Record | str, ...]) -> list[float]:
    records = [each for each in lists if isinstance(each, Record)]
    return [value for each in records for _, value in each.fields if isinstance(value, float)]


@pytest.mark.parametrize("task", ["block_stacking", "tall_towers"])
def test_drawn_goals_are_read_back_exactly(task: str, tmp_path: Path) -> None:
    registry = load("block_stacking")
    for seed in range(20):
        drawn = draw(registry, task, seed)
        program = registry.programs[drawn.instance.program]
        path = tmp_path / f"{task}.txt"
        path.write_text(format_lists(registry, program, drawn.instance.arguments))
        assert read_lists(path, registry, program, drawn.objects) == {"goal": drawn.goal}


ORDER = "(parcel_0, table, {}, 0 rad, 0 s, 0 N, 0 kg, 0, gentle)"
REST = "\nnears:\nkinds:\nrest:\n"


@pytest.mark.parametrize(
    "text, meters",
    [
        ("5 cm", 0.05),
        ("5cm", 0.05),
        ("-35 mm", -0.035),
        ("0.05 m", 0.05),
        ("+1.5e1 mm", 0.015),
        ("2e-2 m", 0.02),
    ],
)
def test_lengths_may_be_written_in_any_unit(text: str, meters: float, tmp_path: Path) -> None:
    found = read(tmp_path / "goal.txt", f"orders: {ORDER.format(text)}{REST}")
    assert found["orders"][0]["gap"] == pytest.approx(meters)


def test_degrees_and_milliseconds_are_read_in_si(tmp_path: Path) -> None:
    row = "(parcel_0, table, 0 m, 180 deg, 250 ms, 1 N, 2 kg, 3, rough)"
    order = read(tmp_path / "goal.txt", f"orders: {row}{REST}")["orders"][0]
    assert (order["turn"], order["after"]) == (pytest.approx(3.14159265), pytest.approx(0.25))
    assert (order["push"], order["load"], order["share"]) == (1.0, 2.0, 3.0)


def test_each_kind_of_number_has_the_unit_that_its_declaration_asks_for() -> None:
    fields = [field.type for field in PARCELS.records["Order"]]
    assert set(BASE_UNITS) <= set(fields)


NEARS = "nears: (parcel_0, 5 cm), (parcel_1, 6 cm)"


@pytest.mark.parametrize(
    "text",
    [
        f"rest:\n{NEARS}\norders:\nkinds:",  # in another order
        "# one\norders:   # no\n\n\nnears:\n (parcel_0,\n5 cm),\n  (parcel_1, 6cm)\nkinds: #2\nrest:",
        f"orders:\r\n{NEARS}\r\nkinds:\r\nrest:\r\n",
        f"orders: {NEARS} kinds: rest: ",
    ],
)
def test_layout_comments_and_order_are_free(text: str, tmp_path: Path) -> None:
    found = read(tmp_path / "goal.txt", text)
    assert {name: list(map(str, each)) for name, each in found.items()} == {
        "orders": [], "nears": ["(parcel_0, 0.05)", "(parcel_1, 0.06)"], "kinds": [], "rest": [],
    }  # fmt: skip


FLAWED = [  # text, the line at fault, part of the sentence
    ("", None, "expected 'orders: …', a list that 'send' takes"),
    ("orders:\nnears:\nrest:\n", None, "expected 'kinds: …'"),
    ("order:\n", 1, "expected a list of 'send' \\(orders, nears, kinds, rest\\), found 'order'"),
    ("orders\n", 1, "expected ':', found the end"),
    ("orders (", 1, "expected ':', found '\\('"),
    ("orders:\norders:\n", 2, "'orders' is there twice"),
    ("orders:\nnears:\nkinds: gentle,\n", 3, "another element after the comma"),
    ("orders: (parcel_0, table", 1, "expected ',', found the end"),
    ("orders: (parcel_0 table)", 1, "expected ',', found 'table'"),
    ("orders: (parcel_0, table)", 1, "expected ',', found '\\)'"),
    ("orders:\n\n  ()", 3, "expected \\(parcel, to, gap, turn, after, push, load, share, care\\) of Order"),
    ("orders: parcel_0", 1, "expected '\\(', found 'parcel_0'"),
    (f"orders: {ORDER.format('5 cm')[:-1]}, 7)", 1, "expected '\\)', found ','"),
    (f"orders: {ORDER.format('5 miles')}", 1, "no unit 'miles'"),
    (f"orders: {ORDER.format('5 cn')}", 1, "there is no unit 'cn'; there is: N, cm"),
    (f"orders: {ORDER.format('table')}", 1, "expected a number for 'gap', found 'table'"),
    (f"orders: {ORDER.format('5 cm').replace('gentle', 'gentel')}", 1, "expected gentle or rough"),
    (f"orders: {ORDER.format('5 cm').replace('parcel_0', 'parcel_9')}", 1, "name of an object in the scene"),
    (f"orders: {ORDER.format('5 cm').replace('parcel_0', 'parcle_0')}", 1, "did you mean 'parcel_0'"),
    (f"orders: {ORDER.format('5 cm').replace('parcel_0', 'table')}", 1, "a Parcel, and 'table' is a Table"),
    (f"orders: {ORDER.format('5 cm').replace('parcel_0', '7')}", 1, "for 'parcel', found '7'"),
    ("orders:\nnears: (parcel_0, 5 cm),\n(parcel_1, 9 cm)", 3, "0.02 .. 0.08 for 'gap', found '9 cm'"),
    ("orders:\nnears:\nkinds: 7", 3, "gentle or rough or upside_down for 'kinds', found '7'"),
    ("orders:\nnears:\nkinds:\nrest: gentle", 4, "name of an object in the scene for 'rest'"),
    ("orders:\n  @", 2, "expected a name or a number, found '@'"),
    ('orders:\nnears: ("parcel_0", 5 cm)', 2, "expected a name or a number"),
    ("orders: {}", 1, "expected a name or a number, found '{}'"),
    ("orders: (parcel_0, table), \x1b[2J", 1, "expected"),
    ("), (", 1, "expected a list of 'send'"),
    (":::", 1, "expected a list of 'send'"),
]  # fmt: skip


@pytest.mark.parametrize("text, line, sentence", FLAWED)
def test_a_flawed_file_is_a_sentence_with_its_line(
    text: str, line: int | None, sentence: str, tmp_path: Path
) -> None:
    path = tmp_path / "goal.txt"
    with pytest.raises(NtpError, match=sentence) as refused:
        read(path, text)
    message = str(refused.value)
    assert message.startswith(f"{path}: " if line is None else f"{path}:{line}: ")
    assert "\n" not in message and "\x1b" not in message and len(message) < 600


@pytest.mark.parametrize(
    "content, sentence",
    [
        (b"\xff\xfe\x00g", "expected text in UTF-8"),
        (b"orders:\n" + b"# more\n" * 200_000, "too long for one"),
    ],
)
def test_what_is_no_such_text_is_refused(content: bytes, sentence: str, tmp_path: Path) -> None:
    with pytest.raises(NtpError, match=sentence) as refused:
        read(tmp_path / "goal.txt", content)
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize("number", ["3 kg", "90 deg", "2 s"])
def test_a_unit_of_another_kind_is_refused(number: str, tmp_path: Path) -> None:
    with pytest.raises(NtpError, match="gap"):
        read(tmp_path / "goal.txt", f"orders: {ORDER.format(number)}{REST}")


@pytest.mark.parametrize("number", ["1e999 m", "-1e400 cm"])
def test_an_infinite_number_is_refused(number: str, tmp_path: Path) -> None:
    with pytest.raises(NtpError, match="gap|number"):
        read(tmp_path / "goal.txt", f"orders: {ORDER.format(number)}{REST}")


def test_a_file_that_is_not_there_is_a_sentence(tmp_path: Path) -> None:
    for path in (tmp_path / "none.txt", tmp_path):
        with pytest.raises(NtpError, match="No such file|Is a directory"):
            read_lists(path, PARCELS, SEND, OBJECTS)


@settings(max_examples=200, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.lists(st.sampled_from(
    "orders nears kinds rest : , ( ) parcel_0 parcel_3 table gentle 5 cm 3 mm -1e3 0.04 m # @ \n".split(" ")
), max_size=30))  # fmt: skip
def test_any_words_are_read_or_refused_in_a_sentence(tmp_path: Path, words: list[str]) -> None:
    try:
        found = read(tmp_path / "goal.txt", " ".join(words))
    except NtpError as error:
        assert "\n" not in str(error)
    else:
        assert list(found) and all(isinstance(each, tuple) for each in found.values())
