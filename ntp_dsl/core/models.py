"""From a file of weights to policies: the one core's, or the per-library baseline's."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

from ntp_dsl.common.text import counted
from ntp_dsl.core.default_bodies import with_default_bodies
from ntp_dsl.core.dispatch.dispatcher import Dispatcher
from ntp_dsl.core.dispatch.learned import LearnedDispatcher
from ntp_dsl.core.dispatch.rule import RuleDispatcher
from ntp_dsl.core.learnt.learnt_rows import LearntRows, rows_beside
from ntp_dsl.core.learnt.preferring import PreferringExpert
from ntp_dsl.core.one_core import FORMAT, MADE_BY, OneCore, one_core
from ntp_dsl.core.per_library.checkpoint import check_fits, core_of
from ntp_dsl.core.per_library.model import Core
from ntp_dsl.core.per_library.policy import LearnedPolicy
from ntp_dsl.core.policy import OneShotPolicy
from ntp_dsl.core.pretraining.config import fewer_than_usual
from ntp_dsl.core.shown import Shown, Told
from ntp_dsl.core.weights import read_weights
from ntp_dsl.demonstrations.demonstration import Demonstration
from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.language.registry import Registry
from ntp_dsl.policies.expert import Expert
from ntp_dsl.policies.protocol import Policy
from ntp_dsl.traces.decision import Dispatch


class Model(Protocol):
    """What was learnt, for one library."""

    @property
    def training(self) -> str:
        """Return what it was trained with, where that is far less than usual; else nothing."""

    def shown(self, demonstration: Demonstration, whole_scopes: bool = False) -> Policy:
        """Return the policy that does what a demonstration shows.

        Args:
            whole_scopes: every program reads its lists from the whole demonstration.
        """

    def told(self, probability: float = 1.0) -> Policy:
        """Return the policy that does what the lists among its arguments say.

        Args:
            probability: that these are what was meant.
        """


@dataclass(frozen=True)
class OneCoreModel:
    """The one core: it needs no training on the library."""

    core: OneCore
    registry: Registry
    dispatch: Dispatch
    rows: LearntRows = LearntRows({})

    @property
    def training(self) -> str:
        """Say whether training was far shorter than usual, and whose rows were learnt."""
        few = fewer_than_usual(self.core.recipe.get("pretraining"))
        learnt = [f"{counted(each.decisions, 'decision')} of {name}" for name, each in self.rows.rows.items()]
        return ", ".join([*([few] if few else []), *learnt])

    def read(self, demonstration: Demonstration, whole_scopes: bool = False) -> Shown:
        """Return a demonstration as it is read."""
        preferring = [name for name, each in self.rows.preferences.items() if each.terms]
        expert = PreferringExpert(self.registry, self._dispatcher(), preferring) if preferring else None
        return Shown(self.registry, demonstration, self.core.grounding, whole_scopes, expert)

    def shown(self, demonstration: Demonstration, whole_scopes: bool = False) -> OneShotPolicy:
        return OneShotPolicy(self.read(demonstration, whole_scopes), self._dispatcher())

    def told(self, probability: float = 1.0) -> OneShotPolicy:
        return OneShotPolicy(Told(self.registry, self.core.grounding, probability), self._dispatcher())

    def _dispatcher(self) -> Dispatcher:
        expert = Expert(self.registry)
        if self.dispatch is Dispatch.RULE:
            return RuleDispatcher(expert)
        return LearnedDispatcher(expert, self.core.dispatch, self.rows.preferences)


@dataclass(frozen=True)
class BaselineModel:
    """A core that was trained on the library's own traces."""

    core: Core
    training = ""  # how many traces it takes depends on the library

    def shown(self, demonstration: Demonstration, whole_scopes: bool = False) -> Policy:
        if whole_scopes:
            raise NtpError("a checkpoint of `ntp train` has learnt its scopes: omit --whole-scopes")
        return LearnedPolicy(self.core, demonstration)

    def told(self, probability: float = 1.0) -> Policy:
        raise NtpError("a checkpoint of `ntp train` needs a demonstration, and is told nothing: omit --model")


def open_model(path: Path, registry: Registry, program: str, dispatch: Dispatch | None = None) -> Model:
    """Return what a file of weights can do with a library.

    Args:
        program: the one that will be run.
        dispatch: how the one core finds the next call, learned by default; the baseline has its own way.

    Raises `NtpError` for what is no checkpoint, and for a baseline's that was trained on other declarations.
    """
    weights = read_weights(path, MADE_BY)
    if weights.format[0] == FORMAT:
        core, rows = one_core(weights, path), rows_beside(registry)
        used = sorted(registry.called_by(program) & rows.rows.keys())
        if used and dispatch is Dispatch.RULE:
            names = ", ".join(used)
            raise NtpError(f"the rule knows nothing of the rows learnt of {names}: omit --dispatch rule")
        known = with_default_bodies(rows.applied(registry))
        return OneCoreModel(core, known, dispatch or Dispatch.LEARNED, rows)
    if dispatch is not None:
        raise NtpError(f"{path}: is a checkpoint of `ntp train`, which has its own way: omit --dispatch")
    baseline = core_of(weights, path).core
    check_fits(baseline.memory, registry, program, path)
    return BaselineModel(baseline)
