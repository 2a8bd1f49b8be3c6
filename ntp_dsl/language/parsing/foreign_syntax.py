"""Lines as other languages write them, and what each would be here: guesses, which the caller tries."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence

from ntp_dsl.language.syntax.foreign_units import in_our_units
from ntp_dsl.language.syntax.formatter import format_expression

Rewrite = str | Callable[[re.Match[str]], str]
NAME = r"[A-Za-z_]\w*"
VALUE = rf"{NAME}(?:\.{NAME})?"
MAX_LENGTH = 200  # characters of a line that is rewritten: the patterns look far ahead
GAP = 10 * " "  # in a line that no person wrote
CLAUSE = r"(?:requires|achieves|success:|when|if)"
OPENED = {"(": ")", "[": "]", "{": "}"}
FILLERS = frozenset("the each every do then begin call await yield let var auto return".split())
KEYWORD_OF = {"any": "some", "exists": "some", "some": "some"}  # of a quantifier; `all` for every other
OPERATORS: Mapping[str, str] = {
    "is": "==", "equals": "==", "eq": "==", "isnt": "!=", "neq": "!=", "ne": "!=", "gt": ">", "lt": "<",
    "ge": ">=", "le": "<=", "to": "..", "until": "..", "through": "..", "plus": "+", "minus": "-",
    "times": "*", "one": "1", "two": "2", "three": "3", "four": "4", "five": "5", "six": "6", "seven": "7",
    "eight": "8", "nine": "9", "ten": "10",
}  # fmt: skip

# Synonyms of several words of the language.
UNCERTAIN = frozenset(
    "while from returns objects init program task target done until at using every each of".split()
)
SYNONYMS: Mapping[str, str] = {
    "if": "when", "while": "when", "foreach": "for", "forall": "all", "every": "all", "each": "all",
    "exists": "some", "of": "in", "extends": "is", "isa": "is", "inherits": "is", "from": "in",
    "pre": "requires", "precondition": "requires", "preconditions": "requires", "needs": "requires",
    "expects": "requires", "assumes": "requires", "where": "if",
    "post": "achieves", "postcondition": "achieves", "effect": "achieves", "effects": "achieves",
    "ensures": "achieves", "provides": "achieves", "returns": "achieves",
    "objects": "scene", "init": "scene", "program": "run", "task": "goal", "target": "goal",
    "done": "success", "until": "success", "at": "on", "using": "with", "List": "list",
}  # fmt: skip


def _quantified_twice(match: re.Match[str]) -> str:
    word = KEYWORD_OF.get(match["word"], "all")
    loops = " ".join(f"for {each}" for each in re.split(r"\s*,\s*", match["loops"]))
    return f"{match['head']}{word} {match['body'].strip()} {loops}"


def _quantified(match: re.Match[str]) -> str:
    """Rewrite `forall x in xs: c`; here the condition comes first."""
    word = KEYWORD_OF.get(match["word"], "all")
    loop = f"for {match['name']} in {match['list']}{match['if'] or ''}"
    return f"{match['head']}{word} {match['body'].strip()} {loop}"


def _among(match: re.Match[str]) -> str:
    members = re.split(r"\s*,\s*", match["members"].strip())
    return "(" + " or ".join(f"{match['thing']} == {each}" for each in members) + ")"


def _grouped(match: re.Match[str]) -> str:
    return f"{match['margin']}{match['type'].lower()}s: {match['count']} {match['type']} on"


def _looped(match: re.Match[str]) -> str:
    """Rewrite `for a, b in T` as two loops."""
    return " ".join(f"for {each} in {match['list']}" for each in re.split(r"\s*,\s*", match["names"]))


def _at_most(match: re.Match[str]) -> str:
    return f"not (at least {int(match['count']) + 1} {match['rest']}){match['colon']}"


def _more_than(match: re.Match[str]) -> str:
    return f"at least {int(match['count']) + 1}"


def _membered(match: re.Match[str]) -> str:
    return f"enum {match['name']}: {re.sub(r'[ ]*[|;/][ ]*', ', ', match['rest'])}"


def _methods(match: re.Match[str]) -> str:
    given = f", {match['rest']}" if match["rest"].strip() else ""
    return f"{match['name']}({match['thing']}{given})"


# What has one translation; each rewrites a whole line.
CERTAIN: Sequence[tuple[str, Rewrite]] = (
    (rf"^type\s+({NAME})\s*(?:[(:<=-]|<:)\s*({NAME})\s*[)>]?\s*:?\s*$", r"type \1 is \2"),
    (rf"^enum\s+(?P<name>{NAME})(?:\s+|\s*[:=({{\[]+\s*)(?P<rest>{NAME}.*?)\s*[)}}\]]*$", _membered),
    (rf"^record\s+({NAME})\s*[:=({{\[]+\s*({NAME}\s*:.*?)\s*[)}}\]]*:?$", r"record \1(\2)"),
    (rf"^constant\s+([a-z_]\w*)(?:\s*(?:=|->)\s*|\s+(?:(?:is|as|of)\s+)?)({NAME})$", r"constant \1: \2"),
    (rf"^(predicate\s+{NAME}\s*\(.*\))\s*(?::|=>|=|>|returns?\b|is\b|as\b)\s*({NAME})\s*:?$",
     r"\1 -> \2"),
    (r"^(predicate\s.*\))\s*->\s*(?:bool|boolean|Bool)\b", r"\1"),
    (rf"^(\s*)for(?:each)?\s*(?:each\b|every\b|var\b)?\s*\(?\s*({NAME})(?:\s+(?:in|of)\b|\s*(?::|<-|=))\s*({NAME})\s*\)?"
     r"\s*(?:do\b|\{)?\s*:?$", r"\1for \2 in \3:"),
    (r"\bat_least\b|\b[Aa]t [Ll]east\b", "at least"),
    (r"\bat most (?P<count>\d+) (?P<rest>[^:]+?)(?P<colon>\s*:?)$", _at_most),
    (r"\b(?:more than|over) (?P<count>\d+)\b", _more_than),
    (r"^(\s*)unless\b\s*(.+?)\s*:?$", r"\1when not (\2):"),
    (r"^(.*?)\b(all|some)\s*\((.+\bfor\b.+)\)(\s*:?)$", r"\1\2 \3\4"),
    (rf"^(.*?)({VALUE}(?: \w+)?)\s*([<>]=?)\s*({VALUE}(?:\([^()]*\))?)\s*([<>]=?)\s*(.+)$",
     r"\1\2 \3 \4 and \4 \5 \6"),
    (rf"^(\s*(?:scene:)?\s*{NAME}:\s*)({NAME})(?:\s+x\s*|\s*[*:×,(]\s*|\s+)(\d+)\)?\s+on\b", r"\1\3 \2 on"),
    (rf"^(\s*)[-*•]\s+({NAME}.*)$", r"\1\2"),
    (rf"(?P<thing>{NAME}\([^()]*\)|{VALUE})\s+in\s+[(\[{{](?P<members>[\w,\s]+)[)\]}}]", _among),
    (rf"\bfor ([A-Z]\w*) ((?!in\b){NAME})\b", r"for \2 in \1"),
    (rf"(?<=[:>])\s*\[\s*({NAME})\s*\]", r" list[\1]"),
    (rf"\blist\s*(?:of\b\s*|<|\()\s*({NAME})\s*[>)]?", r"list[\1]"),
    (r"->(?=\w)", "."),
    (rf"^(\s*(?:scene:)?\s*{NAME}:\s*\d+)(?:\s*x\s+|\s*[*×]\s*)({NAME})\s+on\b", r"\1 \2 on"),
    (r"^(\s*)(?:'''|\"|')([^\"']+?)(?:'''|\"|')$", r'\1"""\2"""'),
    (rf"^(?P<head>.*?)\b(?P<word>forall|all|every|each|exists|some)\s*\(?(?P<name>{NAME}) in"
     rf" (?P<list>{NAME})(?P<if> if [^:]+?)?\s*[:,|.)]\s*(?P<body>.+)$", _quantified),
    (rf"^(?P<head>.*?)\b(?P<word>forall|all|every|exists|some)\s*\(?(?P<loops>{NAME} in {NAME}"
     rf"(?:\s*,\s*{NAME} in {NAME})+)\s*[:|.)]\s*(?P<body>.+)$", _quantified_twice),
    (r"^((?:program|api)\s.*\))\s*->\s*(?:None|void|\(\))(.*)$", r"\1\2"),
    (rf"^(task\s+{NAME})\s*\(\s*\)\s*:?$", r"\1:"),
    (r"^(\s*)(?:if|when)\b\s*(.+?)\s*\b(?:then|do)\s*:?$", r"\1when \2:"),
    (rf"^(\s*)(?:if|when)\b\s*(.+?)\s*\bthen\s+({NAME}\(.+)$", r"\1when \2: \3"),
    (r"^(\s*)(?:post|effects?)\s*:\s*(.+)$", r"\1achieves \2"),
    (r"^(.*?)\bany\s*\((.+\bfor\b.+)\)(\s*:?)$", r"\1some \2\3"),
    (rf"^(\s*)({NAME}\([^()]*\))\s*(?:\bthen\b|;)\s*({NAME}\(.*)$", r"\1\2\n\1\3"),
    (rf"({NAME})\s*\[\s*\]", r"list[\1]"),
    (r"\bList\s*\[", "list["),
    (r"^(\s*(?:requires|achieves))\s*:\s*(.+)$", r"\1 \2"),
    (r"^(\s*(?:scene|initially|goal|run|success))\s+([^\s:=].*)$", r"\1: \2"),
    (r"^constant\s+([A-Z]\w*)\s+([a-z]\w*)$", r"constant \2: \1"),
    (r"(?<=[(,])(\s*)([A-Z]\w*)\s+([a-z]\w*)(?=\s*[,)])", r"\1\3: \2"),
    (r"(=\s*\d+)\s*(?:-|–|\bto\b|\bthrough\b)\s*(\d+)", r"\1..\2"),
    (rf"\b(?!list\b)({NAME})\[({NAME}[^\[\]]*)\]", r"\1(\2)"),
    (rf"^use\s+({NAME})\.ntp$", r"use \1"),
)  # fmt: skip
# Guesses, in the order in which they are tried.
LIKELY: Sequence[tuple[str, Rewrite]] = (
    (rf"^(\s+)({NAME}\([^()]*\)\s+(?:and|or)\s.+)$", r"\1requires \2"),
    (rf"^use\s+({NAME})[.:/].*$", r"use \1"),
    (rf"^use\s+({NAME})\s+(?:import|as|from)\b.*$", r"use \1"),
    (rf"^((?:program|api)\s.*\))\s*->\s*{NAME}(.*)$", r"\1\2"),
    (rf"^(task\s+{NAME})\s*\(.*\)\s*:?$", r"\1:"),
    (r"^(\s*)(?:if|when|while)\b\s*(.+?)\s*(?:\bthen|\bdo|\{)\s*:?$", r"\1when \2:"),
    (r"^(\s*)(?:goal|success|post|effects?)\s*:\s*(.+)$", r"\1achieves \2"),
    (rf"^(\s*)(?:{NAME}\s+)?{NAME}\s*:?=\s*(?:await\s+)?({NAME}\(.*)$", r"\1\2"),
    (rf"^(?P<head>.*?)\b(?P<word>forall|all|every|each|exists|some|any)\s*\(?(?P<name>{NAME}) in"
     rf" (?P<list>{NAME})(?P<if> if [^:]+?)?\s*[:,|.)]\s*(?P<body>.+)$", _quantified),
    (rf"^(?P<head>.*?)\b(?P<word>forall|all|every|exists|some)\s*\(?(?P<loops>{NAME} in {NAME}"
     rf"(?:\s*,\s*{NAME} in {NAME})+)\s*[:|.)]\s*(?P<body>.+)$", _quantified_twice),
    (r"^(.*?)\bany\s*\((.+\bfor\b.+)\)(\s*:?)$", r"\1some \2\3"),
    (r"^(.*?)\bany\s+(.+\bfor\b.+)$", r"\1some \2"),
    (r"^(.*?)\b(?:no|none|never)\s+(.+\bfor\b.+)$", r"\1all not \2"),
    (rf"^(\s*{CLAUSE}\s*)((?!.*\b(?:all|some)\b).+\sfor\s.+)$", r"\1all \2"),
    (r"^(predicate[^:]*\((?:[^()]*)\):?\s+)((?!.*\b(?:all|some)\b).+\sfor\s.+)$", r"\1all \2"),
    (r"^(.*=\s*)(?:range\s*)?[\[(]\s*(\d+)\s*,\s*(\d+)\s*[\])](.*)$", r"\1\2..\3\4"),
    (r"^(?P<margin>\s*)(?P<count>\d+(?:\s*\.\.\s*\d+)?)\s+(?P<type>[A-Z]\w*)\s+on\b", _grouped),
    (rf"^(\s*)({NAME}\([^()]*\))\s*(?:\band\b|\bthen\b|&&|,|;)\s*({NAME}\(.*)$", r"\1\2\n\1\3"),
    (rf"\bfor (?P<names>{NAME}(?:\s*,\s*{NAME})+) in (?P<list>{NAME})", _looped),
    (rf"^type\s+({NAME})\s*,\s*({NAME})$", r"type \1 is \2"),
)  # fmt: skip
COMPILED = {re.compile(pattern): rewrite for table in (CERTAIN, LIKELY) for pattern, rewrite in table}


def _measured(match: re.Match[str]) -> str:
    """Write `5.08 cm` for `2 in`, and `0.002 mm` for `2 µm`."""
    meant = in_our_units(float(match["value"]), match["unit"])
    return match.group() if meant is None else format_expression(meant)


# Signs and notations of numbers; not `1,500 kg`, which may be a thousand and a half, and not `height=2,4`.
NOTATIONS: Sequence[tuple[re.Pattern[str], Rewrite]] = (
    (re.compile("≤"), "<="),
    (re.compile("≥"), ">="),
    (re.compile("≠|<>"), "!="),
    (re.compile(r"\s*(?:∧|&&)\s*"), " and "),
    (re.compile(r"\s*(?:∨|\|\|)\s*"), " or "),
    (re.compile(r"(?:¬|!(?!=))\s*"), "not "),
    (re.compile(r"(?<![\w.,=\]])(?<!=\s)(0|\d+(?!,\d{3}(?!\d))),(\d+)(?![\w]*[,.]\d)"), r"\1.\2"),
    (re.compile(r"(?<![\w.)\]])\.(\d+)"), r"0.\1"),
    (re.compile(r"(?<![\w.])(\d+)\.(?![\w.])"), r"\1"),
    (re.compile(r"(?<![\w)\].])(?<![\w)\].]\s)\+\s*(?=\d)"), ""),
    (re.compile(r"−(?=\s*\d)"), "-"),
    (re.compile(r"(?<=\d)\s*°(?!\s*[A-Z])"), " deg"),
    (re.compile(r"(?<![\w.])(?P<value>\d+(?:\.\d+)?)\s*(?P<unit>[µμ](?:m|s)\b|in(?=\s*(?:[,):]|\.\.|and\b|or\b|$)))"),
     _measured),
)  # fmt: skip
METHOD = re.compile(rf"(?P<thing>{VALUE})\.(?P<name>{NAME})\((?P<rest>[^()]*)\)")
INFIX = re.compile(rf"(?P<left>{VALUE})\s+(?P<name>{NAME})\s+(?P<right>{VALUE})")
NAMED = re.compile(rf"(?<=[(,])\s*{NAME}\s*[:=]\s*(?!=)")
WORD = re.compile(NAME)
LIST = re.compile(rf"({NAME})\s*:\s*list\b")
ELEMENT = re.compile(rf"({NAME})\.{NAME}")


def certain_rewrites(text: str) -> Iterator[str]:
    """Yield what a line of another language, or with other notations of numbers, is in this one."""
    if len(text) > MAX_LENGTH or GAP in text.strip():
        return
    whole, comment = _without_comment(text)
    code = whole.rstrip("; ") if whole.endswith(";") else whole
    for pattern, rewrite in [*COMPILED.items()][: len(CERTAIN)]:
        found = pattern.sub(rewrite, code)
        if found != code:
            yield found + comment
    ours = code
    for pattern, notation in NOTATIONS:
        ours = pattern.sub(notation, ours)
    if ours != code:
        yield ours + comment
    if code + comment != text:
        yield code + comment


def rewrites(rows: Sequence[str], row: int, column: int) -> Iterator[str]:
    """Yield what a line may be meant to be, the likeliest first.

    Args:
        column: of the letter at which the parser stumbles, from zero.
    """
    if len(rows[row]) > MAX_LENGTH or GAP in rows[row].strip():
        return
    text, comment = _without_comment(rows[row])
    for pattern, rewrite in COMPILED.items():
        found = pattern.sub(rewrite, text)
        if found != text:
            yield found + comment
    kinds = _words(text, column), _brackets(text, column), _loops(rows, text), _joined(text, column)
    yield from (each + comment for kind in kinds for each in kind)


def _without_comment(text: str) -> tuple[str, str]:
    match = re.search(r"\s*(?:#|//).*$", re.sub(r'"[^"]*"', lambda each: "_" * len(each.group()), text))
    if match is None:
        return text, ""
    comment = text[match.start() :]
    return text[: match.start()], comment.replace("//", "#", 1) if "#" not in comment else comment


def _words(text: str, column: int) -> Iterator[str]:
    """Leave out filler words; rewrite operators that are words, and infix predicates."""
    words = list(WORD.finditer(text))
    near = [each for each in words if each.start() <= column < each.end()]
    near += [each for each in words if each.end() <= column][-1:]
    for match in near:
        before, after = text[: match.start()], text[match.end() :]
        if match.group().lower() in FILLERS:
            yield before + after.lstrip()
        if match.group().lower() in OPERATORS:
            yield f"{before}{OPERATORS[match.group().lower()]}{after}"
            yield f"{before.rstrip()}{OPERATORS[match.group().lower()]}{after.lstrip()}"
    for match in INFIX.finditer(text):
        if match.start("name") <= column <= match.end():
            applied = f"{match['name']}({match['left']}, {match['right']})"
            yield text[: match.start()] + applied + text[match.end() :]


def _brackets(text: str, column: int) -> Iterator[str]:
    """Rewrite brackets of another kind, missing or too many, and what is before or in them."""
    if (found := METHOD.sub(_methods, text)) != text:
        yield found
    if (found := NAMED.sub(lambda each: " " if each.group().startswith(" ") else "", text)) != text:
        yield found
    for place in (column, column - 1):
        if place < 0 or text[place : place + 1] not in OPENED:
            continue
        end = text.find(OPENED[text[place]], place)
        if end < 0:
            continue
        head, inner, rest = text[:place], text[place + 1 : end], text[end + 1 :]
        for opening, closing in ("()", "[]"):
            yield f"{head}{opening}{inner.strip()}{closing}{rest}"
        yield f"{head.rstrip()} {inner.strip()}{rest}"
    if re.search(r"[;:.]\s*$", text):
        yield re.sub(r"[;:.]\s*$", ")", text)


def bracketed(text: str, column: int) -> Iterator[str]:
    """Put the rest of the line in brackets, as a call needs them."""
    text, comment = _without_comment(text)
    body, colon = (text.rstrip()[:-1], ":") if text.rstrip().endswith(":") else (text.rstrip(), "")
    head, inner = body[:column].rstrip(), body[column:].strip()
    if inner and re.search(r"\w$", head) and head.count("(") == head.count(")"):
        yield f"{head}({inner}){colon}{comment}"
        first, comma, rest = inner.partition(",")
        yield f"{head}({first.rstrip()}){comma}{rest}{colon}{comment}"


def _loops(rows: Sequence[str], text: str) -> Iterator[str]:
    """Add the loop that a quantifier lacks: over the only list, by the name of its elements."""
    whole = "\n".join(rows)
    lists = dict.fromkeys(LIST.findall(whole)) or (["goal"] if rows[0].startswith("task") else [])
    element = ELEMENT.search(text)
    if element is None or not re.search(r"\b(?:all|some)\b", text):
        return
    for name in lists:
        loop = f"for {element.group(1)} in {name}"
        yield re.sub(rf"\s+(?:for\s+)?in\s+{name}\b", f" {loop}", text)
        yield f"{text.rstrip()} {loop}"


def _joined(text: str, column: int) -> Iterator[str]:
    """Write `put_in` for `put-in`."""
    if re.search(r"\w$", text[:column]) and re.match(r"[-.]\w", text[column:]):
        yield f"{text[:column]}_{text[column + 1 :]}"
