"""The worlds that ship: a kinematic one, and the planned one with an arm."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from importlib.util import find_spec
from inspect import Parameter, signature

from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.language.registry import Api, Registry
from ntp_dsl.language.syntax.nodes import PYTHON, PredicateDeclaration, Span
from ntp_dsl.semantics.attempts import reads_failures
from ntp_dsl.semantics.layout import SIDES
from ntp_dsl.semantics.observation import Argument
from ntp_dsl.semantics.predicates import BUILT_IN, READINGS
from ntp_dsl.semantics.state import State
from ntp_dsl.semantics.state_changes import changed_by, says_of_state
from ntp_dsl.semantics.value_checks import out_of_range
from ntp_dsl.worlds.attempts import note_attempt
from ntp_dsl.worlds.protocol import ACHIEVED, Failure, Outcome, World
from ntp_dsl.worlds.skill_context import SkillContext

WORLDS = ("kinematic", "bullet", "mujoco")
WITH_ARM = ("bullet", "mujoco")
SIDED = frozenset({"beside", "over_side", "room_beside"})  # predicates whose last argument is a side
ACT = 1.0  # of an act that changes nothing but the state [s]


def make_world(
    name: str, registry: Registry, exact: bool = False, gui: bool = False, arm: str | None = None
) -> World:
    """Return a world that provides all apis and predicates of a library. Imports only that world.

    Args:
        exact: of the kinematic world: objects come to rest exactly where they are released.
        gui: of the bullet world: with a window, in real time.
        arm: of a world with an arm: one that is shipped, or the path of a TOML; the Panda by default.

    Raises `NtpError` for a world that does not exist, and for an api or predicate that it lacks.
    """
    world = _make(name, exact, gui, arm)
    equip(world, registry, name)
    return world


def equip(world: World, registry: Registry, name: str = "given") -> None:
    """Give a world the skills of a library, those in Python included.

    Raises `NtpError` for an api or predicate that neither the world nor Python provides, or that takes
    something else than what provides it.
    """
    counts_failures = reads_failures(registry)
    has_state = counts_failures or any(each.is_state for each in registry.predicates.values())
    needed = [name for name in _members(World) if has_state or name != "facts"]
    if missing := [name for name in needed if not hasattr(world, name)]:
        kind = type(world).__name__
        raise NtpError(f"expected a world, found {kind}, which lacks {', '.join(missing)}; see docs/api.md")
    lacks = lacking(world, registry)
    if lacks:
        known = sorted(world.skills)
        raise NtpError(
            f"the {name} world has nothing for {', '.join(lacks)} of library '{registry.name}'; its `skills` "
            f"are {', '.join(known)}, and the predicates {', '.join(BUILT_IN | READINGS)}; "
            f"others are left to Python: api {lacks[0]}(...) by python"
        )
    for message, _ in misdeclared(world, registry):
        raise NtpError(message)
    skills = own_skills(world)
    for api in registry.apis.values():
        if api.skill == PYTHON:
            skill: Callable[..., Outcome] = partial(_by_python, registry, api, world)
            skill = partial(_carry_out, registry, api, world, skill)
        elif api.skill in skills:
            skill = skills[api.skill]
        else:
            skill = partial(_carry_out, registry, api, world, partial(_wait, world))
        if any(says_of_state(registry, api.achieves)):
            skill = partial(_change_state, registry, api, world, skill)
        if counts_failures:
            skill = partial(_count_failure, api, world, skill)
        world.skills[api.name] = skill


def own_skills(world: World) -> Mapping[str, Callable[..., Outcome]]:
    """Return the skills that a world has itself: none that a library has added."""
    own: Mapping[str, Callable[..., Outcome]] = vars(world).setdefault("_own_skills", dict(world.skills))
    return own


def _members(protocol: type) -> list[str]:
    """Return the names of a protocol's attributes and methods; properties have no value before a reset."""
    methods = [name for name, value in vars(protocol).items() if callable(value) and not name.startswith("_")]
    return [*protocol.__annotations__, *methods]


def _carry_out(
    registry: Registry, api: Api, world: World, skill: Callable[..., Outcome], *arguments: Argument
) -> Outcome:
    """Call a skill; like the worlds' own, it is refused where its api's requirements fail."""
    state = State(registry, world.truth())
    if strayed := out_of_range(api, arguments):  # by a learned program: an expert's number was tested before
        return Outcome(False, Failure.NOT_READY, {"out of range": strayed})
    named = api.bind(arguments)
    lacks = [str(fact) for fact in state.literals(api.requires, named) if not state.holds(fact)]
    if lacks:
        return Outcome(False, Failure.NOT_READY, {"lacks": lacks})
    return skill(*arguments)


def _by_python(registry: Registry, api: Api, world: World, *arguments: Argument) -> Outcome:
    outcome: Outcome = registry.python.get("skill", api.name)(SkillContext(registry, world), *arguments)
    return outcome


def _wait(world: World, *arguments: Argument) -> Outcome:
    """Take the time that an act takes which changes nothing but the state."""
    world.settle(ACT)
    return ACHIEVED


def _change_state(
    registry: Registry, api: Api, world: World, skill: Callable[..., Outcome], *arguments: Argument
) -> Outcome:
    """Call a skill; where it succeeds, what it achieves of the state holds."""
    outcome = skill(*arguments)
    if outcome.achieved:
        world.facts = changed_by(api, arguments, State(registry, world.truth()))
    return outcome


def _count_failure(api: Api, world: World, skill: Callable[..., Outcome], *arguments: Argument) -> Outcome:
    """Call a skill; count where it fails with the objects that it is given."""
    outcome = skill(*arguments)
    note_attempt(world, api.name, arguments, outcome)
    return outcome


def lacking(world: World, registry: Registry) -> list[str]:
    """Return the apis and predicates of a library that neither the world nor Python provides."""
    own = own_skills(world)
    apis = [
        api.name
        for api in registry.apis.values()
        if api.skill not in {PYTHON, *own} and not _needs_no_skill(registry, api)
    ]
    predicates = [
        declared.name
        for declared in registry.predicates.values()
        if declared.body is None and not _is_provided(declared)
    ]
    return [*sorted(apis), *sorted(predicates)]


def _needs_no_skill(registry: Registry, api: Api) -> bool:
    """Return whether all that an api achieves is of the state, so that it needs no skill."""
    found = [*says_of_state(registry, api.achieves)]
    return api.skill == api.name and bool(found) and all(found)


def misdeclared(world: World, registry: Registry) -> Iterator[tuple[str, Span]]:
    """Yield what is wrong with each api or predicate that its provider does not match, and where."""
    for api in registry.apis.values():
        if api.skill != PYTHON and api.skill in world.skills:
            yield from _misfit(
                f"api '{api.name}'", api.parameters, world.skills[api.skill], api.skill, api.span
            )
    for name, declared in registry.predicates.items():
        provider = declared.provider
        is_read = declared.result is not None and declared.by is None  # of the scene, where no world tells it
        if declared.body is not None or provider not in (READINGS if is_read else BUILT_IN | READINGS):
            continue
        test = partial((BUILT_IN | READINGS)[provider], None)  # all but the observation
        yield from _misfit(f"predicate '{name}'", declared.parameters, test, provider, declared.name_span)
        if provider in SIDED and (odd := _no_sides(declared, registry)):
            yield (
                f"predicate '{name}' takes {', '.join(SIDES)}, and '{odd}' is none of these",
                declared.name_span,
            )
        if declared.result is not None and provider not in READINGS:
            yield f"predicate '{name}' is a reading, and '{provider}' is true or false", declared.name_span


def _no_sides(declared: PredicateDeclaration, registry: Registry) -> str:
    """Return a member of the last parameter's enumeration that is no side; empty where all are."""
    members = registry.enums.get(declared.parameters[-1].type.name, ("any value",))
    return next((each for each in members if each not in SIDES), "")


def _misfit(
    what: str, given: Sequence[object], provider: Callable[..., object], name: str, span: Span
) -> Iterator[tuple[str, Span]]:
    """Yield that a provider does not take as many arguments as are declared, if so."""
    takes = [each for each in signature(provider).parameters.values() if each.default is Parameter.empty]
    if any(each.kind is Parameter.VAR_POSITIONAL for each in takes) or len(takes) == len(given):
        return
    names = ", ".join(each.name for each in takes) or "nothing"
    yield f"{what} has {len(given)} parameters, and '{name}', by which it is provided, takes {names}", span


def _is_provided(declared: PredicateDeclaration) -> bool:
    """Return whether the world, Python, or (for a reading of one object) the scene provides a predicate."""
    provider = declared.provider
    by_scene = declared.result is not None and declared.by is None and len(declared.parameters) == 1
    return declared.is_state or provider in {PYTHON, *BUILT_IN, *READINGS} or by_scene


def _make(name: str, exact: bool, gui: bool, arm: str | None) -> World:
    if gui and name != "bullet" and name in WORLDS:
        raise NtpError(f"the {name} world has no window; --gui goes with --world bullet")
    if arm is not None and name not in WITH_ARM and name in WORLDS:
        raise NtpError(f"the {name} world has no arm; --arm goes with --world {' or '.join(WITH_ARM)}")
    if name == "kinematic":
        from ntp_dsl.worlds.kinematic import KinematicWorld

        return KinematicWorld(0.0) if exact else KinematicWorld()
    if name in WITH_ARM:
        if name == "bullet" and find_spec("pybullet") is None:  # asked first, as solvers take long to import
            raise ModuleNotFoundError("the bullet world needs PyBullet", name="pybullet")
        from ntp_dsl.worlds.arm import ArmWorld

        return ArmWorld(name, arm, gui)
    raise NtpError(f"no world is called '{name}'; there are {', '.join(WORLDS)}")
