"""`ntp graph`: the call graph of a library, as a tree in the terminal or as a picture."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from ntp_dsl.cli.options import Library
from ntp_dsl.cli.outputs import check_ending
from ntp_dsl.common.files import written_whole
from ntp_dsl.graph.calls import CallGraph, Node, call_graph
from ntp_dsl.language.loader import load

STYLES = {"task": "bold yellow", "program": "bold blue", "api": "green"}


def command(
    library: Library,
    out: Annotated[Path | None, typer.Option(help="Write a picture to FILE.svg.")] = None,
    program: Annotated[str | None, typer.Option(help="Show only this program and what it calls.")] = None,
    list: Annotated[
        bool, typer.Option("--list", help="List tasks, programs and apis instead, one per line.")
    ] = False,
) -> int:
    """Show the call graph of a library, with the contracts and docstrings of its programs.

    Example: ntp graph block_stacking --out runs/block_stacking.svg
    """
    graph = call_graph(load(library), program)
    if out is not None:
        from ntp_dsl.graph.svg import draw

        check_ending(out, ".svg")
        with written_whole(out) as partial:
            partial.write_text(draw(graph), encoding="utf-8")
        print(f"wrote {out}")
    elif list:
        _print_list(graph)
    else:
        _print_tree(graph)
    return 0


def _print_tree(graph: CallGraph) -> None:
    from rich.text import Text
    from rich.tree import Tree

    from ntp_dsl.cli.display import answers

    tree = Tree(Text(graph.name, style="bold"))
    expanded: set[str] = set()

    def grow(branch: Tree, node: Node, label: str, above: tuple[str, ...]) -> None:
        line = Text(f"{label}: " if label else "", style="dim")
        line.append(node.signature, style=f"not dim {STYLES[node.kind]}")
        if node.key in above:
            branch.add(line.append("  ↺ recursive", style="not bold magenta"))
            return
        if node.key in expanded:
            branch.add(line.append("  see above", style="not bold dim"))
            return
        expanded.add(node.key)
        if node.summary:
            line.append(f"\n{node.summary}", style="not bold italic default")
        for clause in node.contract:
            line.append(f"\n{clause}", style="not bold default")
        twig = branch.add(line)
        for callee, around in graph.calls(node.key):
            grow(twig, callee, around, (*above, node.key))

    for root in graph.roots():
        grow(tree, root, "", ())
    answers.print(tree)


def _print_list(graph: CallGraph) -> None:
    from rich.table import Table
    from rich.text import Text

    from ntp_dsl.cli.display import answers

    table = Table(box=None, show_header=False, padding=(0, 2, 0, 0))
    for node in graph.nodes:
        name = Text(node.signature, style=STYLES[node.kind])
        table.add_row(node.kind, name, Text(node.summary))
    answers.print(table)
