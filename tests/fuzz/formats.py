"""The file formats under test: for each a small valid file, mutations of it, and its reader."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from random import Random
from typing import Any

import numpy as np
import pyarrow as pa
from file_mutations import NAMES, mutated_bytes, mutated_json
from old_files import VERSION_2
from pyarrow import parquet

from ntp_dsl.cli.app import run
from ntp_dsl.core.one_core import load_one_core, shipped_core
from ntp_dsl.core.per_library.checkpoint import load_core, save_core
from ntp_dsl.core.per_library.config import CoreConfig
from ntp_dsl.core.per_library.memory import Memory
from ntp_dsl.core.per_library.model import Core
from ntp_dsl.datasets.manifest import MANIFEST, read_manifest, recorded_files
from ntp_dsl.demonstrations.demonstration import Demonstration
from ntp_dsl.demonstrations.demonstration_files import read_demonstration
from ntp_dsl.demonstrations.foreign_tables import imported
from ntp_dsl.demonstrations.pose_maps import read_map, template
from ntp_dsl.language.registry import Registry
from ntp_dsl.tasks.goal_text import read_lists
from ntp_dsl.tasks.task_files import read_tasks
from ntp_dsl.traces.reader import read_trace

Mutation = Callable[[Random], bytes]


@dataclass(frozen=True)
class Format:
    """A format of files."""

    name: str  # of a file
    valid: bytes
    mutation: Mutation
    read: Callable[[Path], object]  # and use


def formats(registry: Registry, folder: Path) -> dict[str, Format]:
    """Return all formats, with samples recorded into a folder."""
    words = ["record", "block_stacking", "few_placements", "-n", "1", "--out", str(folder)]
    assert run(words) == 0
    trace = (folder / "episode_00000.trace.jsonl").read_bytes()
    shown = folder / "episode_00000.demo.parquet"
    manifest = (folder / MANIFEST).read_text()
    core = folder / "core.safetensors"
    save_core(Core(CoreConfig(4, 2, 2), Memory.of(registry)), {"command": "ntp train"}, core)

    def manifests(path: Path) -> None:
        recorded_files(path.parent)
        read_manifest(path.parent, registry)

    one = shipped_core().read_bytes()
    table, old_table = parquet.read_table(shown), _old_table(shown)
    old_manifest = _old_manifest(json.loads(manifest))
    return {
        "trace": Format("a.trace.jsonl", trace, _lines(trace), _use_trace),
        "trace_2": Format("a.trace.jsonl", VERSION_2, _lines(VERSION_2), _use_trace),
        "demonstration": Format("a.parquet", _written(table), _parquet(table), read_demonstration),
        "demonstration_1": Format("a.parquet", _written(old_table), _parquet(old_table), read_demonstration),
        "checkpoint": Format("a.safetensors", core.read_bytes(), _safetensors(core.read_bytes()), load_core),
        "core": Format("a.safetensors", one, _safetensors(one), load_one_core),
        "goal": _goal(registry, read_demonstration(shown)),
        **_poses(folder, read_demonstration(shown)),
        "tasks": _document("a.json", TASKS, read_tasks),
        "authors_tasks": _document("a.json", AUTHORS, read_tasks),
        "manifest": _document(MANIFEST, json.loads(manifest), manifests),
        "manifest_1": _document(MANIFEST, old_manifest, manifests),
    }


TASKS = {
    "format": "ntp-tasks",
    "version": 2,
    "tasks": [
        {
            "id": "1",
            "objects": [
                {
                    "name": "block_0",
                    "type": "Block",
                    "size": [0.05, 0.05, 0.05],
                    "traits": [["colour", "red"]],
                },
                {
                    "name": "block_1",
                    "type": "Block",
                    "size": [0.05, 0.05, 0.05],
                    "shape": "box",
                    "fixed": True,
                },
            ],
            "goal": [{"item": "block_0", "support": "block_1"}],
        }
    ],
}
AUTHORS = {
    "name": "stacking",
    "scene": {
        "objects": [
            {"name": f"cube_{n}", "filename": f"cubes/cube_{n}.urdf", "scale": [0.05, 0.05, 0.05]}
            for n in range(2)
        ]
    },
    "tasks": [{"id": "1", "goals": [{"name": "pick_place", "src": "cube_0", "target": "cube_1"}]}],
}


def _use_trace(path: Path) -> None:
    trace = read_trace(path)
    for state in trace.states:
        assert state.by_name is not None and (state.held is None or state.held in state.by_name)
    assert repr(trace) and list(trace.events()) is not None


def _goal(registry: Registry, shown: Demonstration) -> Format:
    program = registry.programs["stack"]
    text = b"# as read\ngoal: (block_0, block_1),\n    (block_2, block_0)\n"
    return Format(
        "goal.txt",
        text,
        lambda chance: mutated_bytes(chance, text),
        lambda path: read_lists(path, registry, program, shown.objects),
    )


def _poses(folder: Path, shown: Demonstration) -> dict[str, Format]:
    """Return a table of poses, and its map."""
    scene = shown.objects
    text = template(scene)
    (folder / "map.toml").write_text(text)
    told = read_map(folder / "map.toml")
    names = [name for each in (told.gripper, *told.objects.values()) for name in each.position]
    rows = [["time", "closed", *names], *([k / 10, k % 2, *[0.1 * k] * len(names)] for k in range(4))]
    table = "\n".join(",".join(map(str, row)) for row in rows).encode()
    (folder / "poses.csv").write_bytes(table)
    return {
        "poses": Format(
            "a.csv",
            table,
            lambda chance: mutated_bytes(chance, table),
            lambda path: imported(path, told, scene),
        ),
        "map": Format(
            "a.toml",
            text.encode(),
            lambda chance: mutated_bytes(chance, text.encode()),
            lambda path: imported(folder / "poses.csv", read_map(path), scene),
        ),
    }


def _document(name: str, document: Any, read: Callable[[Path], object]) -> Format:
    text = json.dumps(document)
    return Format(name, text.encode(), lambda chance: mutated_json(chance, text), read)


def _lines(content: bytes) -> Mutation:
    lines = content.splitlines()

    def mutated(chance: Random) -> bytes:
        changed = lines.copy()
        for _ in range(chance.choice((1, 1, 2))):
            at = chance.randrange(min(len(changed), len(lines))) if chance.random() < 0.7 else 0
            action = chance.random()
            if action < 0.85:
                changed[at] = mutated_json(chance, lines[at].decode())
            elif action < 0.9:
                del changed[at]
            elif action < 0.95:
                changed[at:at] = [changed[at]] * chance.choice((1, 300))
            else:
                return mutated_bytes(chance, content)
        return b"\n".join(changed) + b"\n"

    return mutated


def _old_manifest(manifest: dict[str, Any]) -> dict[str, Any]:
    rows = [
        {**row, "goal": [dict(each["fields"]) for each in row["goal"]], "outcome": "done"}
        for row in manifest["episodes"]
    ]
    return {**manifest, "version": 1, "episodes": rows, "trouble": 0.15}


def _old_table(path: Path) -> Any:
    """Return a demonstration as the first version had it: places relative to the gripper."""
    whole = read_demonstration(path)
    header = {
        "format": "ntp-demonstration",
        "version": 1,
        "things": [{"name": each.name, "type": each.type, "size": each.size} for each in whole.objects],
        "notes": {"task": "few_placements", "seed": 4, "goal": [{"item": "a", "support": "b"}]},
    }
    columns = {"time": whole.times, "closed": whole.closed}
    columns |= {f"position.{name}": list(whole.relative[:, n]) for n, name in enumerate(whole.names)}
    return pa.table(columns).replace_schema_metadata({"ntp-demonstration": json.dumps(header)})


def _parquet(table: Any) -> Mutation:
    """Change the file's bytes, the header's JSON, or a column."""
    content = _written(table)
    header = table.schema.metadata[b"ntp-demonstration"].decode()

    def mutated(chance: Random) -> bytes:
        action = chance.random()
        if action < 0.3:
            return mutated_bytes(chance, content)
        if action < 0.7:
            text = mutated_json(chance, header)
            return _written(table.replace_schema_metadata({"ntp-demonstration": text}))
        changed = _changed_column(chance, table)
        return _written(changed if action < 0.9 else changed.replace_schema_metadata(None))

    return mutated


def _changed_column(chance: Random, table: Any) -> Any:
    at, rows = chance.randrange(table.num_columns), table.num_rows
    name = table.column_names[at]
    strange = [
        pa.array(["a"] * rows), pa.array([None] * rows), pa.array([[1.0]] * rows), pa.array([[]] * rows),
        pa.array([float("nan")] * rows), pa.array([1e308] * rows), pa.array([[1e308] * 3] * rows),
        pa.array([[float("inf")] * 3] * rows), pa.array([[None] * 3] * rows), pa.array([2**62] * rows),
        pa.array([b"\0"] * rows), pa.array([[1.0] * n for n in range(rows)]), pa.array([{"a": 1}] * rows),
        pa.array(np.full(rows, np.datetime64("2020-01-01"))), pa.array([None, [1.0, 2.0, 3.0]] * rows)[:rows],
    ]  # fmt: skip
    match chance.randrange(5):
        case 0:
            return table.drop_columns([name])
        case 1:
            return table.slice(0, chance.choice((0, 1, rows // 2)))
        case 2:
            new = chance.choice([each for each in NAMES if each != "\ud800"])
            prefix = chance.choice(("", "position.", "orientation.", "deviation."))
            return table.rename_columns([prefix + new if n == name else n for n in table.column_names])
        case 3:
            extra = chance.choice(("facts", "deviation.block_0", "orientation.block_0", "time", "x"))
            return table.append_column(extra, chance.choice(strange))
    return table.set_column(at, name, chance.choice(strange))


def _written(table: Any) -> bytes:
    sink = pa.BufferOutputStream()
    parquet.write_table(table, sink)
    written: bytes = sink.getvalue().to_pybytes()
    return written


def _safetensors(content: bytes) -> Mutation:
    """Change the file's bytes, its table of tensors, one of its descriptions, or the weights."""
    length = int.from_bytes(content[:8], "little")
    header, weights = content[8 : 8 + length].decode(), content[8 + length :]

    def mutated(chance: Random) -> bytes:
        action = chance.random()
        if action < 0.1:
            return mutated_bytes(chance, content)
        if action < 0.25:
            return _joined(mutated_json(chance, header), weights)
        if action < 0.35:
            return _joined(header.encode(), mutated_bytes(chance, weights)[: len(weights)])
        table = json.loads(header)
        documents = sorted(name for name, text in table["__metadata__"].items() if text.startswith("{"))
        part = chance.choice(documents)
        text = mutated_json(chance, table["__metadata__"][part]).decode("utf-8", "replace")
        table["__metadata__"][part] = text
        return _joined(json.dumps(table).encode(), weights)

    return mutated


def _joined(header: bytes, weights: bytes) -> bytes:
    return len(header).to_bytes(8, "little") + header + weights
