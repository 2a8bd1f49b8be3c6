"""A process pool whose results do not depend on its size."""

from __future__ import annotations

import os
import signal
import sys
from collections import deque
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from itertools import islice
from multiprocessing import active_children, get_context
from typing import Any, NoReturn, TypeVar

from ntp_dsl.common.garbage import collect_seldom
from ntp_dsl.common.signals import ENDING, ignore

Result = TypeVar("Result")

AHEAD = 8  # tasks for each worker that are handed out before the first result is awaited
GRACE = 3  # [s] to remove unfinished files
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
    numbers = iter(range(count))
    with ProcessPoolExecutor(workers, get_context("spawn"), _start, (open_worker,)) as pool:
        try:
            with _signals_blocked():  # also in the new processes, until they can answer
                waiting = deque(pool.submit(_work, number) for number in islice(numbers, AHEAD * workers))
            while waiting:
                yield waiting.popleft().result()
                waiting.extend(pool.submit(_work, number) for number in islice(numbers, 1))
        except BaseException as error:
            pool.shutdown(wait=False, cancel_futures=True)
            for process in active_children():
                process.terminate()
            if isinstance(error, BrokenProcessPool):
                raise ChildProcessError(KILLED) from error
            raise


@contextmanager
def _signals_blocked() -> Iterator[None]:
    earlier = signal.pthread_sigmask(signal.SIG_BLOCK, ENDING)
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, earlier)


_worker: Callable[[int], Any] | Exception
_is_working = False


def _start(open_worker: Callable[[], Callable[[int], Any]]) -> None:
    """Open the worker. An error is kept until the first task: raised here, it would break the pool."""
    global _worker
    collect_seldom()
    _answer_signals(signal.SIG_DFL)  # nothing is unfinished yet
    signal.pthread_sigmask(signal.SIG_UNBLOCK, ENDING)
    try:
        _worker = open_worker()
    except Exception as error:
        _worker = error
    _answer_signals(_exit)


def _answer_signals(handler: Any) -> None:
    for each in ENDING:
        signal.signal(each, handler)


def _exit(*_: object) -> NoReturn:
    """End the process, and let its task remove unfinished files first."""
    _answer_signals(ignore)
    if not _is_working:
        os._exit(1)
    signal.alarm(GRACE)  # ends the process where a library swallows the exception
    sys.exit(1)


def _work(number: int) -> Any:
    global _is_working
    if isinstance(_worker, Exception):
        raise _worker
    try:
        try:
            _is_working = True
            return _worker(number)
        finally:
            _is_working = False
    except SystemExit:
        os._exit(1)  # the pool would catch it and wait for more
