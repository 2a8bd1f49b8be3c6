"""Words of English that mean the same in any library: relations, and verbs by what their parts stand for.

Nothing here names a library's words. A word that is lacking is reported as not understood.
"""

from __future__ import annotations

import re
from enum import Enum


class Role(Enum):
    """What a noun phrase is in a clause: what is moved or told of, or what a preposition relates it to."""

    THEME = "theme"
    ON = "on"
    IN = "in"
    UNDER = "under"
    TO = "to"
    FROM = "from"
    WITH = "with"
    BESIDE = "beside"
    OF = "of"
    OBJECT = "object"  # of a verb of which nothing is known


GOALS = frozenset({Role.ON, Role.IN, Role.TO})  # where something gets to
FIRM = frozenset({Role.UNDER, Role.FROM, Role.BESIDE})  # what no type can tell

PREPOSITIONS: dict[tuple[str, ...], Role] = {
    **dict.fromkeys(
        [("on",), ("onto",), ("upon",), ("atop",), ("over",), ("above",), ("on", "top", "of"), ("on", "to")]
        + [("on", "the", "top", "of"), ("to", "the", "top", "of"), ("at", "the", "top", "of")],
        Role.ON,
    ),
    **dict.fromkeys([("in",), ("into",), ("inside",), ("within",), ("inside", "of")], Role.IN),
    **dict.fromkeys([("under",), ("below",), ("beneath",), ("underneath",)], Role.UNDER),
    **dict.fromkeys([("to",), ("at",), ("toward",), ("towards",), ("against",), ("up", "to")], Role.TO),
    **dict.fromkeys([("from",), ("off",), ("out", "of"), ("away", "from"), ("off", "of")], Role.FROM),
    **dict.fromkeys([("with",), ("using",), ("along", "with"), ("together", "with")], Role.WITH),
    **dict.fromkeys(
        [("beside",), ("near",), ("by",), ("next", "to"), ("close", "to"), ("alongside",), ("behind",)]
        + [("around",), ("between",), ("along",), ("across",), ("in", "front", "of"), ("ahead", "of")],
        Role.BESIDE,
    ),
    **dict.fromkeys([("of",), ("for",), ("as",)], Role.OF),
    **dict.fromkeys([("go", "of"), ("rid", "of"), ("hold", "of"), ("care", "of")], Role.THEME),
}

RELATIONS = frozenset(word for each in PREPOSITIONS for word in each)

_AXES = (
    ("left", "right"), ("ahead forward forwards front", "behind back backward backwards"),
    ("above over", "below under"), ("near", "far"), ("before", "after"),
)  # fmt: skip
# Words for sides, with those for the other side.
OPPOSITES = {
    word: frozenset(other.split())
    for axis in _AXES
    for side, other in (axis, axis[::-1])
    for word in side.split()
}

IRREGULAR = {
    "held": "hold", "borne": "bear", "bore": "bear", "taken": "take", "took": "take", "gotten": "get",
    "got": "get", "has": "have", "had": "have", "having": "have", "laid": "lay",
    "goes": "go", "gone": "go", "went": "go", "stood": "stand", "brought": "bring", "given": "give",
    "gave": "give", "sat": "sit", "kept": "keep", "hung": "hang",
    "built": "build",
    "lit": "light", "fed": "feed", "led": "lead", "dying": "die", "lying": "lie",
}  # fmt: skip


def stem(word: str) -> str:
    """Return what the forms of a verb have in common: placed, placing and places are of plac."""
    word = IRREGULAR.get(word, word)
    if word.endswith(("ied", "ies")) and len(word) > 4:
        return f"{word[:-3]}y"
    for ending in ("ing", "ed", "es", "s", "e"):
        if word.endswith(ending) and len(word) - len(ending) >= 3 and not word.endswith("ss"):
            word = word[: -len(ending)]
            break
    return word[:-1] if len(word) > 3 and word[-1] == word[-2] and word[-1] not in "ls" else word


def _stems(text: str) -> frozenset[str]:
    return frozenset(map(stem, text.split()))


# Verbs whose subject is where something is: "the tray carries the cup".
BEARING = _stems(
    "want need carry hold support bear receive get take contain have accommodate host accept house shoulder"
)
# Those of which the subject may also be what gets somewhere: "the guest takes the seat".
TAKING = _stems("take get occupy claim")
# Verbs whose object is where something gets: "top the tray with the cup".
COVERING = _stems("cover top crown cap load fill stock furnish equip burden")
# Nouns and verbs for what stands on one another.
TOWERS = _stems("tower stack pile heap column")
# Verbs of which the first of two objects is where something gets: "give the tray the cup".
GIVING = _stems("give hand offer assign lend serve allot")
# Verbs of what is kept "for" something: that comes there.
RESERVING = _stems(
    "set keep reserve use prepare save clear free designate assign mean intend want choose pick"
)
PASSIVE = frozenset("be is are was were been being gets get".split())
# Nouns for where something belongs: "the tray is the place for the cup".
SITES = frozenset(
    "place spot base support foundation home destination target position bottom seat stand pedestal holder "
    "container platform receptacle carrier location perch space room".split()
)
# Ordinary verbs of handling and being: none of them tells which relation is meant.
COMMON = _stems(
    """plop pop chuck toss throw stick shove dump sling hoist haul drag slot nestle wedge prop park
    situate install locate relocate reposition settle station stash tidy slip slap hang lower
    raise hand pass return position lodge plonk bung place tuck steer guide convey transport
    ferry relay switch put set lay move bring carry take pick grab get go stand sit rest lie
    belong drop stack pile send leave come end find arrange transfer shift lift fetch deposit
    keep build use make want need balance stow join land stay remain insert slide heap mount
    perch deliver plant seat choose reserve happen work task job see sure ensure check certain
    add store live love like gather collect reside accompany remember aim plan prefer ask expect stay
    wait follow continue proceed let help try serve act fit occupy appear show stick spend"""
)
PRONOUNS = frozenset("it they them this that these those".split())
# What "the first", "the latter" of several is, by its place among them.
ORDINALS = dict(zip("first former second third latter last".split(), (0, 0, 1, 2, -1, -1), strict=True))
ONES = frozenset("one ones".split())
# Words that turn, hedge or widen what is said, or ask: none of it is guessed at.
REFUSED = frozenset(
    "none not never no without except but dont unless neither nor nothing cannot outside or either maybe "
    "perhaps possibly whose hardly rarely barely scarcely seldom was used if whether than most several few "
    "many half remaining remainder else zero avoid refrain stop undo fail fails destroy lack lacks refuse "
    "refuses hate hates prevent forbid dislike reject cancel unstack non nobody forbidden ban banned forget "
    "beware doubt pretend harm wrong illegal dangerous useless pointless unfit unwelcome crosswise".split()
)
ASKING = frozenset(
    "is are was were does did do has have which what where who why".split()
)  # a question's first
LEAVING = _stems("leave vacate quit abandon")  # "the guest leaves the seat"
DETERMINERS = frozenset("the a an this that these those its some any".split())
EVERY = frozenset("all every each both everything".split())
OPENINGS = frozenset(
    "then next now please first second third finally lastly afterwards also and so after that to start "
    "once when after by firstly secondly thirdly last you we i can could should must will would just".split()
)
FILLERS = frozenset(
    """up down there here right directly carefully gently again back together out away too as well
    only which who whom what where when while so be been being is are was were will would should
    must can could shall may might do does did done let have has had not very exactly precisely just
    also please i we you he she they us me want need like supposed meant going ready top side on in
    at of to for with by kindly from off and or but then than now next first second third last
    finally lastly afterwards after before your my our some one proper correct better best that this
    these those the a an it ordered order asked mind found ought touching thanks thank regarding
    quick quickly okay ok nice mate later kind how about happy finished through good new always
    itself soon hey hello hi robot dear meanwhile anyway sure its them their way own""".split()
)
# Verbs that say much the same. (Static word vectors were tried: of such pairs they find less than half.)
ALIKE = [
    _stems(row)
    for row in """wash rinse clean scrub wipe cleanse
screw fasten bolt fix secure tighten attach mount
join connect link couple unite combine
light illuminate ignite kindle
open unlock unfasten uncover
close shut seal lock
fill load stock replenish refill restock supply
empty clear unload vacate drain discharge evacuate
serve deliver hand supply bring dispense
sort classify group order separate
turn rotate twist spin swivel
swap exchange switch trade interchange
press push squeeze
pull drag draw
cut slice chop trim
pour tip decant
mix stir blend shake
heat warm cook boil
cool chill freeze
weigh measure
stamp mark label frank print
paint colour coat dye varnish
dry towel
polish shine buff sand
remove withdraw extract
collect gather fetch retrieve
check inspect examine test verify try
pack wrap box bundle
build assemble construct erect make
water irrigate sprinkle
feed nourish""".splitlines()
]
LINKS = frozenset({",", "and"})
# Verbs of attention: what they name is not what is to be done, but what comes next is about it.
ATTENTION = _stems(
    "find look locate identify see notice consider remember search spot watch check know start begin"
)
# Verbs of taking: what becomes of the thing, the next clause says.
HANDLING = ATTENTION | _stems("take grab pick get fetch lift hold go")
# Nouns that name nothing of a scene.
GENERAL = frozenset(
    "piece tower pile stack heap row group collection pair task job lot rest help sake goal aim idea plan "
    "wish chance favour minute moment point result purpose intention course position order way turn time "
    "thing amount quantity count offset distance gap spacing angle".split()
)
LARGE = frozenset(
    "large larger largest big bigger biggest tall taller tallest long longest wide widest".split()
)
SMALL = frozenset(
    "small smaller smallest little short shorter shortest tiny low lowest narrow narrowest".split()
)
NUMBERS = {
    word: str(number)
    for number, word in enumerate(
        "zero one two three four five six seven eight nine ten eleven twelve thirteen fourteen fifteen "
        "sixteen seventeen eighteen nineteen twenty".split()
    )
}

# Words that name nothing of a library, and verbs that it need not know.
KNOWN = FILLERS | OPENINGS | PRONOUNS | ONES | SITES | GENERAL | DETERMINERS | EVERY | {"other", *NUMBERS}
KNOWN |= LARGE | SMALL | RELATIONS | {"middle"}
KNOWN_VERBS = BEARING | COVERING | GIVING | COMMON | ATTENTION

TOKEN = re.compile(r"'s\b|[^\W\d_]+(?:'t\b)?|[0-9]{1,15}(?:\.[0-9]{1,15})?|[,;.!?{}()]|-(?=\d)")
CONTRACTED = re.compile(r"\b(it|that|there|what|here|let|he|she|who)'s\b|'(?:d|ll|re|ve|m)\b")
NUMBERED = re.compile(r"(?:\bno\.|\bnumber|#)\s*(?=\d)|(?<=[a-z])-(?=\d)")
RIGHT_NOW = re.compile(
    r"\bright (?=(?:next to|on top|onto|under|underneath|into|behind|above|beside|away)\b)"
)
NOT_ONLY = re.compile(r"\bnot only\b(.*?)\bbut\b(?: also\b)?")
# Two negations that say what is to be: nothing is to stay outside.
NOTHING_OUTSIDE = re.compile(
    r"\b(?:(?:don't|do not|never) leave(?: any| the)? (?P<a>[\w ]+?)|"
    r"none of the (?P<b>[\w ]+?) (?:are|is|be|should be) left|"
    r"(?:shouldn't|mustn't|should not|must not) be any (?P<c>[\w ]+?) left) (?:outside|out)(?: of)?\b"
)
POLITE = re.compile(
    r"\bwhy (?:don't|not)\b|^\W*(?:can|could|would|will) you\b|\bdon't forget to\b"
    r"|\bwouldn't mind\b|\bif you (?:would|could|can|please|like|will|have (?:a|the) \w+)\b"
    r"|\bi wish\b|\bit would be \w+ if\b"
)
PARENTHESES = re.compile(
    r"\b(?:after (?:that|this)|in turn|in (?:that|this|the same|the given) order|respectively|of course"
    r"|by the way|for now|for me|as well)\b"
)
# "Between 28 and 36 mm", "from 2 cm to 3 cm": two numbers, the unit of both behind the second.
MINUS = re.compile(r"(?P<before>(?:\S+\s+){0,2})\bminus (?P<number>\d+|[a-z]+)")
SIGN = re.compile(r"(?<=\s)[-\u2012-\u2015\u2212]\s*(?=\d)")
RANGE = re.compile(
    r"\b(?:between|from) (\d+(?:\.\d+)?) ?([a-z]+)? (?:and|to) "
    r"(\d+(?:\.\d+)?) ?(mm|cm|m|degrees|deg|kg|s|n)\b"
)
LIST_AFTER = re.compile(r":(?=[^.;:]*,)")
LISTED = re.compile(r"\b(?:as well as|plus|but also|while|whereas)\b|&")
CAMEL = re.compile(r"(?<=[a-z])(?=[A-Z])")


def name_words(name: str) -> list[str]:
    """Return the words of an identifier: `left_plate`, `FrontDoor` and `block_3` are two each."""
    return TOKEN.findall(CAMEL.sub(" ", name).lower())


def number_of(word: str) -> str:
    """Return the digits of a number, in digits or as a word; nothing for other words."""
    digits = NUMBERS.get(word, word)
    return digits if digits.isdecimal() and digits.isascii() else ""


def _signed(minus: re.Match[str]) -> str:
    """Return "at minus 4 cm" with a sign; "8 cm minus 4 cm" is left as it is, which nothing understands."""
    before, number = minus["before"] or "", minus["number"]
    is_difference = bool(re.search(r"\d\s*([mck]?m|deg\w*|k?g|s|n)?\s*$", before))
    return minus[0] if is_difference else f"{before}-{NUMBERS.get(number, number)}"


def words(text: str) -> list[str]:
    """Return the words, numbers and stops of a text in lower case; names fall into their words."""
    text = CAMEL.sub(" ", text).lower().replace("\u2019", "'")
    text = CONTRACTED.sub(lambda match: f"{match[1] or ''} ", text)
    text = SIGN.sub("-", MINUS.sub(_signed, text))
    text = RANGE.sub(lambda match: f" {match[1]} {match[2] or match[4]} , {match[3]} {match[4]} ", text)
    text = LIST_AFTER.sub(" , ", text)
    text = NOT_ONLY.sub(r"\1 and ", text)
    text = NOTHING_OUTSIDE.sub(lambda m: f"all {m['a'] or m['b'] or m['c']} are in", text)
    text = NUMBERED.sub(" ", RIGHT_NOW.sub("", text))
    return [
        each
        for each in TOKEN.findall(PARENTHESES.sub(" ", LISTED.sub("and", POLITE.sub(" ", text))))
        if each != "very"
    ]


def with_synonyms(verbs: frozenset[str]) -> frozenset[str]:
    """Return stems of verbs, and of those that say much the same."""
    return verbs.union(*(group for group in ALIKE if not group.isdisjoint(verbs)))


def singular(word: str) -> str:
    """Return a noun without its plural's ending."""
    for ending, instead in (("ies", "y"), ("ves", "f"), ("sses", "ss"), ("shes", "sh"), ("ches", "ch")):
        if word.endswith(ending) and len(word) > len(ending) + 1:
            return word[: -len(ending)] + instead
    if word.endswith(("xes", "zes", "oes")) and len(word) > 4:
        return word[:-2]
    return (
        word[:-1] if word.endswith("s") and not word.endswith(("ss", "us", "is")) and len(word) > 2 else word
    )


def singulars(word: str) -> set[str]:
    """Return what a noun may be the plural of, and itself: knives are of a knife, leaves of a leaf."""
    found = {word, singular(word)}
    if word.endswith("ves"):
        found.add(f"{word[:-3]}fe")
    if word.endswith("es") and len(word) > 3:
        found |= {word[:-1], word[:-2]}
    return found
