"""The argument of skills in Python: the world, with calls of its apis checked beforehand."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.language.registry import Registry
from ntp_dsl.semantics.observation import Argument
from ntp_dsl.semantics.value_checks import guess, out_of_range, plain, types_of, unfit_call
from ntp_dsl.worlds.protocol import Failure, Outcome, World


class SkillContext:
    """The world as a skill sees it; all but `call` is the world's own."""

    def __init__(self, registry: Registry, world: World) -> None:
        self._registry, self._world = registry, world

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_"):
            raise AttributeError(name)
        return getattr(self._world, name)

    def call(self, api: str, arguments: Sequence[Argument] = ()) -> Outcome:
        """Call an api. Raises `NtpError` for an unknown api, and for arguments that it does not take."""
        apis = self._registry.apis
        if api not in apis:
            raise NtpError(f"no api is called '{api}'{guess(api, apis)}")
        if isinstance(arguments, str) or not isinstance(arguments, Sequence):
            raise NtpError(f"world.call('{api}', {arguments!r}): write the arguments as a tuple: (x, y)")
        given = plain(tuple(arguments))
        types = types_of(self._registry, self._world.truth())
        if wrong := unfit_call(self._registry, apis[api], given, types):
            raise NtpError(f"world.call('{api}', {given!r}): {wrong}")
        if strayed := out_of_range(apis[api], given):
            return Outcome(False, Failure.NOT_READY, {"out of range": strayed})
        return self._world.call(api, given)
