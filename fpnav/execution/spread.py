"""How work is spread: in this process, on worker processes, or on a Dask cluster.

The pipeline sees one function: results come back in order, and no more than a bounded number of
items is under way, so memory does not grow with the length of a log.
"""

from __future__ import annotations

import os
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Executor, Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from multiprocessing import get_context, parent_process
from multiprocessing.connection import wait
from typing import Any, Protocol, TypeVar

from fpnav.errors import FpnavError, UsageError

Item = TypeVar("Item")
Answer = TypeVar("Answer")

AHEAD = 4
"""Items under way per worker."""


class Spread(Protocol):
    """Somewhere to run a pure function over items, in order."""

    def ordered(
        self, function: Callable[[Item], Answer], items: Iterable[Item]
    ) -> Iterator[Answer]:
        """``function`` of each item, in the order of the items."""
        ...


class Here:
    """In this process, one item after the other."""

    def ordered(
        self, function: Callable[[Item], Answer], items: Iterable[Item]
    ) -> Iterator[Answer]:
        """``function`` of each item."""
        return map(function, items)


class Processes:
    """On worker processes of this machine."""

    def __init__(self, workers: int) -> None:
        self.workers = workers

    def ordered(
        self, function: Callable[[Item], Answer], items: Iterable[Item]
    ) -> Iterator[Answer]:
        """``function`` of each item, spread over the workers.

        Raises
        ------
        FpnavError
            A worker was killed from outside.
        """
        pool = ProcessPoolExecutor(
            self.workers, mp_context=get_context("forkserver"), initializer=_prepare_worker
        )
        try:
            yield from _in_order(pool, function, items, AHEAD * self.workers)
        except BrokenProcessPool as error:
            raise FpnavError(
                "a worker process was killed, most likely for want of memory; rerun with --jobs 1"
            ) from error
        finally:
            pool.shutdown(wait=False, cancel_futures=True)


class Cluster:
    """On the workers of a running Dask scheduler."""

    def __init__(self, address: str) -> None:
        try:
            from dask.distributed import Client
        except ImportError as error:
            raise UsageError("--scheduler needs the extra: pip install 'fpnav[dask]'") from error
        try:
            self.client: Any = Client(address, timeout="10s")
        except (OSError, ValueError) as error:
            raise UsageError(f"--scheduler {address}: no Dask scheduler answers there") from error

    def ordered(
        self, function: Callable[[Item], Answer], items: Iterable[Item]
    ) -> Iterator[Answer]:
        """``function`` of each item, spread over the cluster."""
        workers = max(1, len(self.client.scheduler_info()["workers"]))
        return _in_order(self.client.get_executor(pure=False), function, items, AHEAD * workers)


def make_spread(jobs: int, scheduler: str | None) -> Spread:
    """The spread the options ask for."""
    if scheduler:
        return Cluster(scheduler)
    return Processes(jobs) if jobs > 1 else Here()


def _in_order(
    pool: Executor, function: Callable[[Item], Answer], items: Iterable[Item], ahead: int
) -> Iterator[Answer]:
    waiting: deque[Future[Answer]] = deque()
    for item in items:
        waiting.append(pool.submit(function, item))
        if len(waiting) >= ahead:
            yield waiting.popleft().result()
    while waiting:
        yield waiting.popleft().result()


def _prepare_worker() -> None:
    """Workers leave signals to the parent, end with it, and keep OpenCV to one thread."""
    import signal
    import threading

    import cv2

    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, daemon=True).start()
    cv2.setNumThreads(1)


def _end_with_parent() -> None:
    """Leave at once when the parent is gone, killed before it could say so: a worker that waits
    for items holds both ends of its own queue and would wait for ever."""
    parent = parent_process()
    if parent is not None:
        wait([parent.sentinel])
        os._exit(1)
