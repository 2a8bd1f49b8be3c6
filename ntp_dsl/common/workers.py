"""A process pool whose results do not depend on its size."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from typing import Any, TypeVar

Result = TypeVar("Result")


def in_order(
    open_worker: Callable[[], Callable[[int], Result]], count: int, workers: int
) -> Iterator[Result]:
    """Yield results for 0, 1, …, each a function of its number alone; `open_worker` runs once a process."""
    if workers == 1:
        work = open_worker()
        yield from (work(number) for number in range(count))
        return
    with ProcessPoolExecutor(workers, get_context("spawn"), _start, (open_worker,)) as pool:
        yield from pool.map(_work, range(count))


_worker: Callable[[int], Any] | Exception


def _start(open_worker: Callable[[], Callable[[int], Any]]) -> None:
    """Open the worker. An error is kept until the first task: raised here, it would break the pool."""
    global _worker
    try:
        _worker = open_worker()
    except Exception as error:
        _worker = error


def _work(number: int) -> Any:
    if isinstance(_worker, Exception):
        raise _worker
    return _worker(number)
