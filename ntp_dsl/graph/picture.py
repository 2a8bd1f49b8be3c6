"""The call graph of a library as a value that a notebook shows."""

from __future__ import annotations

from dataclasses import dataclass

from ntp_dsl.graph.calls import CallGraph
from ntp_dsl.graph.svg import draw


@dataclass(frozen=True, repr=False)
class CallPicture:
    """Who calls whom; its `svg` is what `ntp graph --out` writes."""

    graph: CallGraph

    @property
    def svg(self) -> str:
        return draw(self.graph)

    def _repr_svg_(self) -> str:
        return self.svg

    def __repr__(self) -> str:
        return f"<Calls of {self.graph.name}: {len(self.graph.nodes)} nodes, {len(self.graph.edges)} edges>"
