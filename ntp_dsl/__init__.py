"""Declare a library of robot tasks, show a task once, and the arm does it: neural task programming.

    import ntp_dsl

    registry = ntp_dsl.load("block_stacking")
    task = ntp_dsl.draw(registry, "block_stacking", seed=3)
    shown = ntp_dsl.demonstrate(task)
    ntp_dsl.run(task, ntp_dsl.learned_policy(task, shown))

Nothing is imported before it is used. `docs/api.md` has all names; experts, predicates, skills and samplers
in Python are marked with those of `ntp_dsl.authoring`.
"""

from __future__ import annotations

from importlib import import_module

TYPE_CHECKING = False  # as of `typing`, which would be half of what importing the package takes
if TYPE_CHECKING:
    from typing import Any

__version__ = "0.1.0"

_HOMES = {
    "Choice": "ntp_dsl.policies.protocol",
    "Demonstration": "ntp_dsl.demonstrations.demonstration",
    "Diagnostic": "ntp_dsl.language.diagnostics.diagnostics",
    "Disturbances": "ntp_dsl.worlds.protocol",
    "Episode": "ntp_dsl.api",
    "Failure": "ntp_dsl.worlds.protocol",
    "Frame": "ntp_dsl.policies.protocol",
    "NtpError": "ntp_dsl.language.diagnostics.diagnostics",
    "Observation": "ntp_dsl.semantics.observation",
    "Outcome": "ntp_dsl.worlds.protocol",
    "Policy": "ntp_dsl.policies.protocol",
    "Registry": "ntp_dsl.language.registry",
    "Task": "ntp_dsl.api",
    "Trace": "ntp_dsl.traces.trace",
    "World": "ntp_dsl.worlds.protocol",
    "call_graph": "ntp_dsl.libraries",
    "compare": "ntp_dsl.traces.comparison.divergence",
    "demonstrate": "ntp_dsl.api",
    "diagnose": "ntp_dsl.libraries",
    "diagnose_text": "ntp_dsl.language.loader",
    "draw": "ntp_dsl.api",
    "expert_policy": "ntp_dsl.api",
    "learned_policy": "ntp_dsl.api",
    "load": "ntp_dsl.libraries",
    "load_text": "ntp_dsl.libraries",
    "make_world": "ntp_dsl.worlds.catalogue",
    "picture": "ntp_dsl.api",
    "read_demonstration": "ntp_dsl.demonstrations.demonstration_files",
    "read_trace": "ntp_dsl.traces.reader",
    "run": "ntp_dsl.api",
}
__all__ = sorted([*_HOMES, "__version__"])


def __getattr__(name: str) -> Any:
    """Import a public name's module when the name is first used (PEP 562)."""
    if name not in _HOMES:
        raise AttributeError(f"module 'ntp_dsl' has no attribute '{name}'")
    from inspect import isfunction

    from ntp_dsl.extras import needing

    with needing(name):
        value = getattr(import_module(_HOMES[name]), name)
    globals()[name] = _needing(name, value) if isfunction(value) else value
    return globals()[name]


def _needing(name: str, function: Any) -> Any:
    """Return a function that says which extra it needs where it lacks a module."""
    from ntp_dsl.extras import needing

    guarded = needing(name)(function)
    guarded.__module__ = __name__  # where pickle finds it
    return guarded


def __dir__() -> list[str]:
    return __all__
