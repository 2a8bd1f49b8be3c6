"""The key-program memory: a row per program, with a slot for each callee that its declaration names.

The core answers with a slot, never with a name. Keys of slots are fixed and orthonormal, so a program can
only call what it declares, and a new program cannot capture the calls of an old one.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass
from functools import cached_property
from typing import Any

from ntp_dsl.language.diagnostics import NtpError
from ntp_dsl.registry import Callable, Parameter, Registry


@dataclass(frozen=True)
class Signature:
    """Names and types of the arguments that point at objects; lists are not among them."""

    name: str
    hash: str
    object_types: tuple[str, ...]


@dataclass(frozen=True)
class Row:
    """A program's row: its signature and the callees of its slots."""

    signature: Signature
    callees: tuple[str, ...]


@dataclass(frozen=True)
class Memory:
    """What a core was trained over. It travels in the checkpoint."""

    library: str
    registry_hash: str
    types: tuple[str, ...]
    parents: tuple[tuple[str, str | None], ...]
    rows: tuple[Row, ...]
    apis: tuple[Signature, ...]

    @classmethod
    def of(cls, registry: Registry) -> Memory:
        programs = sorted(registry.programs.values(), key=lambda program: program.name)
        rows = tuple(Row(signature(registry, program), program.callees) for program in programs)
        apis = sorted(registry.apis.values(), key=lambda api: api.name)
        return cls(
            registry.name,
            registry.hash,
            tuple(registry.parents),
            tuple(registry.parents.items()),
            rows,
            tuple(signature(registry, api) for api in apis),
        )

    @cached_property
    def slots(self) -> int:
        return max(len(row.callees) for row in self.rows)

    @cached_property
    def arity(self) -> int:
        return max(1, *(len(s.object_types) for s in self.signatures()))

    def signatures(self) -> Iterable[Signature]:
        yield from (row.signature for row in self.rows)
        yield from self.apis

    def index(self, program: str) -> int:
        return self._places[program]

    def row(self, program: str) -> Row:
        return self.rows[self.index(program)]

    def signature(self, name: str) -> Signature:
        return self._by_name[name]

    def takes(self, type_name: str, declared: str) -> bool:
        """Whether a thing of a type may stand where another type is declared."""
        return declared in self.lineage[type_name]

    @cached_property
    def lineage(self) -> dict[str, tuple[str, ...]]:
        """Each type with its ancestors, itself first."""
        parents = dict(self.parents)

        def chain(name: str | None) -> tuple[str, ...]:
            return () if name is None else (name, *chain(parents.get(name)))

        return {name: chain(name) for name in self.types}

    @cached_property
    def _places(self) -> dict[str, int]:
        return {row.signature.name: index for index, row in enumerate(self.rows)}

    @cached_property
    def _by_name(self) -> dict[str, Signature]:
        return {signature.name: signature for signature in self.signatures()}

    def to_json(self) -> dict[str, Any]:
        return asdict(self)

    @classmethod
    def from_json(cls, data: dict[str, Any]) -> Memory:
        return cls(
            data["library"],
            data["registry_hash"],
            tuple(data["types"]),
            tuple((name, parent) for name, parent in data["parents"]),
            tuple(Row(_signature(r["signature"]), tuple(r["callees"])) for r in data["rows"]),
            tuple(_signature(api) for api in data["apis"]),
        )


def signature(registry: Registry, row: Callable) -> Signature:
    return Signature(row.name, row.hash, tuple(object_types(registry, row.parameters)))


def object_types(registry: Registry, parameters: Sequence[Parameter]) -> Iterable[str]:
    """Types of the parameters that are pointers; the type of each chooses its output head."""
    for parameter in parameters:
        if parameter.is_list:
            continue
        if parameter.type not in registry.parents:
            raise NtpError(
                f"'{parameter.name}: {parameter.type}': the core points at objects only, and has no head "
                f"for numbers or enumerations yet; --expert runs such programs"
            )
        yield parameter.type


def _signature(data: dict[str, Any]) -> Signature:
    return Signature(data["name"], data["hash"], tuple(data["object_types"]))
