"""Measures the time of writing traces, and of reading and comparing long ones.

python benchmarks/traces.py recording --episodes 20
python benchmarks/traces.py reading --calls 10000
"""

from __future__ import annotations

import argparse
import io
import json
import tempfile
from collections.abc import Callable
from pathlib import Path
from time import process_time
from typing import Any

import numpy as np

from ntp_dsl.cli.models import model_or_shipped
from ntp_dsl.common.resources import examples_folder
from ntp_dsl.demonstrations.demonstration_files import write_demonstration
from ntp_dsl.evaluation import episodes
from ntp_dsl.evaluation.episodes import Evaluator, Plan
from ntp_dsl.execution.interpreter import Interpreter
from ntp_dsl.semantics.observation import Observation, SceneObject
from ntp_dsl.traces.comparison.divergence import compare
from ntp_dsl.traces.decision import NO_DECISION, Decision
from ntp_dsl.traces.reader import parse_trace
from ntp_dsl.traces.schema import FORMAT, ROOT, VERSION, CallKind, CallOutcome, Execution, Header
from ntp_dsl.traces.writer import TraceWriter

LIBRARY = examples_folder() / "block_stacking"
TRUTH = "_with_truth"  # the interpreter's, which asks for the truth of facts for the trace alone
WRITES = ("header", "state", "call", "returned", "frame", "picture", "end")


def recording(arguments: argparse.Namespace) -> dict[str, Any]:
    """Measure the processor time of writing, including the demonstration's file, over that of the episode.

    Recording the demonstration does not count. Both times are of the same run, since times vary between runs
    by more than a trace costs.
    """
    spent = 0.0

    def timed(write: Callable[..., Any]) -> Callable[..., Any]:
        def measured(*given: Any, **facts: Any) -> Any:
            nonlocal spent
            start = process_time()
            try:
                return write(*given, **facts)
            finally:
                spent += process_time() - start

        return measured

    for name in WRITES:
        setattr(TraceWriter, name, timed(getattr(TraceWriter, name)))
    setattr(Interpreter, TRUTH, timed(getattr(Interpreter, TRUTH)))
    episodes.write_demonstration = timed(write_demonstration)
    model = model_or_shipped(None)
    shares, sizes = [], []
    with tempfile.TemporaryDirectory() as folder:
        plan = Plan(LIBRARY, "block_stacking", model, arguments.world, traces=Path(folder))
        evaluator = Evaluator(plan)
        evaluator.episode(0)  # loading does not count
        for number in range(1, arguments.episodes + 1):
            instance = evaluator.instance(number)
            recorded, _ = evaluator.demonstration(instance, number)
            spent, start = 0.0, process_time()
            evaluator.episode(number, recorded)
            shares.append(spent / (process_time() - start - spent))
        sizes = [path.stat().st_size for path in Path(folder).glob("*.jsonl")]
    return {
        "world": arguments.world,
        "episodes": arguments.episodes,
        "share_of_an_episode": spread(shares),
        "bytes_of_a_trace": spread([float(size) for size in sizes]),
    }


def reading(arguments: argparse.Namespace) -> dict[str, Any]:
    """Measure the processor time [s] of reading two traces that differ in some calls, and comparing them."""
    texts = [written(arguments.calls, seed) for seed in (0, 1)]
    start = process_time()
    a, b = (parse_trace(text, Path("a")) for text in texts)
    read = process_time() - start
    start = process_time()
    found = compare(a, b)
    return {
        "calls": len(a.calls),
        "read_s_for_both": round(read, 3),
        "compare_s": round(process_time() - start, 3),
        "divergences": len(found.divergences),
        "bytes": [len(text) for text in texts],
    }


def written(calls: int, seed: int) -> bytes:
    """Return a trace of programs of four primitives each; one in a hundred primitives depends on the seed."""
    rng = np.random.default_rng(seed)
    stream = io.StringIO()
    writer = TraceWriter(stream)
    objects = tuple(SceneObject(f"block_{n}", "Block", (0.05, 0.05, 0.05)) for n in range(8))
    writer.header(Header(format=FORMAT, version=VERSION, objects=objects))
    root = writer.call(
        ROOT, CallKind.PROGRAM, "build", (), (0, 900), 0, writer.state(seen(objects, 0)), NO_DECISION
    )
    for part in range(calls // 5):
        state = writer.state(seen(objects, part))
        obj = objects[part % 8].name
        number = writer.call(root, CallKind.PROGRAM, "part", (obj,), (part, part + 9), 0, state, NO_DECISION)
        for place in range(4):
            name = f"step_{place if rng.random() > 0.01 else rng.integers(9)}"
            api = writer.call(number, CallKind.API, name, (obj,), None, 0, state, Decision(seconds=0.001))
            writer.returned(api, CallOutcome.ACHIEVED, 0, execution=Execution(planning=0.01, moving=0.1))
        writer.returned(number, CallOutcome.DONE, 0, state=state)
    writer.returned(root, CallOutcome.DONE, 0)
    return stream.getvalue().encode()


def seen(objects: tuple[SceneObject, ...], step: int) -> Observation:
    positions = {obj.name: (0.1 * n, 0.001 * step, 0.025) for n, obj in enumerate(objects)}
    return Observation(objects, positions, (0.4, 0.0, 0.4), False)


def spread(values: list[float]) -> dict[str, float]:
    return {
        "median": round(float(np.median(values)), 5),
        "p95": round(float(np.quantile(values, 0.95)), 5),
        "max": round(max(values), 5),
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    commands = parser.add_subparsers(required=True)
    of_recording = commands.add_parser("recording")
    of_recording.add_argument("--episodes", type=int, default=20)
    of_recording.add_argument("--world", default="bullet")
    of_recording.set_defaults(run=recording)
    of_reading = commands.add_parser("reading")
    of_reading.add_argument("--calls", type=int, default=10_000)
    of_reading.set_defaults(run=reading)
    arguments = parser.parse_args()
    print(json.dumps(arguments.run(arguments), indent=1))


if __name__ == "__main__":
    main()
