"""A process pool whose results do not depend on its size."""

from __future__ import annotations

import signal
import sys
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from multiprocessing import active_children, get_context
from typing import Any, NoReturn, TypeVar

Result = TypeVar("Result")

ENDING = (signal.SIGINT, signal.SIGTERM)
KILLED = "a worker process was killed, perhaps for want of memory: try again with fewer --workers"


def in_order(
    open_worker: Callable[[], Callable[[int], Result]], count: int, workers: int
) -> Iterator[Result]:
    """Yield results for 0, 1, …, each a function of its number alone; `open_worker` runs once a process.

    Raises `ChildProcessError` where a process was killed.
    """
    if workers == 1:
        work = open_worker()
        yield from (work(number) for number in range(count))
        return
    with ProcessPoolExecutor(workers, get_context("spawn"), _start, (open_worker,)) as pool:
        earlier = signal.pthread_sigmask(signal.SIG_BLOCK, ENDING)  # until a process can answer them
        results = pool.map(_work, range(count))
        signal.pthread_sigmask(signal.SIG_SETMASK, earlier)
        try:
            yield from results
        except BaseException as error:
            for process in active_children():
                process.terminate()
            if isinstance(error, BrokenProcessPool):
                raise ChildProcessError(KILLED) from error
            raise


_worker: Callable[[int], Any] | Exception


def _start(open_worker: Callable[[], Callable[[int], Any]]) -> None:
    """Open the worker. An error is kept until the first task: raised here, it would break the pool."""
    global _worker
    for each in ENDING:
        signal.signal(each, _exit)
    signal.pthread_sigmask(signal.SIG_UNBLOCK, ENDING)
    try:
        _worker = open_worker()
    except Exception as error:
        _worker = error


def _exit(*_: object) -> NoReturn:
    sys.exit(1)  # quietly, and not before unfinished files are removed


def _work(number: int) -> Any:
    if isinstance(_worker, Exception):
        raise _worker
    try:
        return _worker(number)
    except SystemExit as error:
        raise KeyboardInterrupt from error
