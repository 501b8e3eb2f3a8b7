"""The promise about other processes: a worker can import the stage, and computes the same with it."""

from __future__ import annotations

import hashlib
import importlib
import multiprocessing
import os
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from multiprocessing.connection import Connection
from operator import attrgetter
from types import ModuleType
from typing import Any, NamedTuple

from pydantic_core import PydanticSerializationError

from followspot.errors import InputError
from followspot.room_document.data import from_data, to_data
from followspot.stage import Stage
from followspot.testing.promises.sources import first_or_none
from followspot.testing.promises.work import contents, sent
from followspot.testing.trial import Trial, reason

TIMEOUT = 60.0
"""Seconds for a fresh process to import a stage and to use it for a few frames."""
_HASH_SEED = "PYTHONHASHSEED"


class _Order(NamedTuple):
    """A trial for another process. params, room: in JSON types; params: None to import the stage only."""

    module: str
    name: str
    params: Mapping[str, Any] | None
    room: Mapping[str, Any]


class _Answer(NamedTuple):
    """The answer of another process. error: of the import; digest: of the outputs; each may be empty."""

    error: str
    digest: str = ""


def does_the_same_in_a_fresh_process(trial: Trial) -> Iterator[str]:
    """A worker that has imported only the runtime imports the stage, and gets the same outputs.

    In another process `hash` of a text, and the order of a set of texts, differ.
    """
    stage = trial.stage
    file = sys.modules[stage.__module__].__file__
    if stage.__module__ == "__main__" or "<locals>" in stage.__qualname__ or file is None:
        return  # `is_found_by_its_name` reports it
    answer = _answer(_order(trial))
    if answer.error:
        yield f"a fresh process cannot import it: {answer.error}"
    elif answer.digest and answer.digest != (own := _digest(trial)) and own == _digest(trial):
        yield (
            "another process gives different outputs with the same seed: sort what comes out of a set, "
            "and use hashlib instead of hash"
        )


def _order(trial: Trial) -> _Order:
    """The order for a trial: to import the stage only, if it cannot be called, or if its parameters or the
    room cannot be written in JSON types.
    """
    module, name = trial.stage.__module__, trial.stage.__qualname__
    if not (trial.computes or trial.yields):
        return _Order(module, name, None, {})
    try:
        params = trial.stage.Params(**trial.params).model_dump(mode="json")
        return _Order(module, name, params, to_data(trial.room))
    except (PydanticSerializationError, InputError):
        return _Order(module, name, None, {})


def _answer(order: _Order) -> _Answer:
    """The answer of a new process, which has imported what every worker imports before its stages."""
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload(["followspot.worker.main"])
    here, there = context.Pipe(duplex=False)
    process = context.Process(target=_carry_out, args=(order, there), daemon=True)
    with _without_main(), _other_hashes():
        process.start()
    there.close()
    try:
        return here.recv() if here.poll(TIMEOUT) else _Answer(f"not done after {TIMEOUT:g} s")
    except EOFError:
        return _Answer("the process ended")
    finally:
        process.kill()
        process.join()


@contextmanager
def _without_main() -> Iterator[None]:
    """Keep processes that start in this block from running this process's script, which may have no guard."""
    main, sys.modules["__main__"] = sys.modules["__main__"], ModuleType("__main__")
    try:
        yield
    finally:
        sys.modules["__main__"] = main


@contextmanager
def _other_hashes() -> Iterator[None]:
    """Give a fork server that starts in this block another hash of texts, even if PYTHONHASHSEED is set."""
    seed = os.environ.get(_HASH_SEED, "random")
    if not seed.isdecimal():  # then each process has its own
        yield
        return
    os.environ[_HASH_SEED] = "random"
    try:
        yield
    finally:
        os.environ[_HASH_SEED] = seed


def _carry_out(order: _Order, answer: Connection) -> None:
    """Send the error that the import of a stage raises, or the checksum of its outputs."""
    try:
        module = importlib.import_module(order.module)
    except BaseException as error:
        answer.send(_Answer(reason(error)))
        return
    if order.params is None:
        answer.send(_Answer(""))
        return
    stage: type[Stage] = attrgetter(order.name)(module)
    trial = Trial(stage, order.params, from_data(order.room))
    answer.send(_Answer("", _digest(trial)))


def _digest(trial: Trial) -> str:
    """Checksum of the outputs of an instance for a few frames."""
    found = first_or_none(trial) if trial.ports.source else sent(trial)
    return hashlib.sha256(repr([contents(message) for message in found]).encode()).hexdigest()
