"""Target: every installed stage, called as a worker does with what has arrived: well-formed and extreme."""

from __future__ import annotations

import logging
import os
import random
import warnings
from contextlib import ExitStack
from typing import Any, NamedTuple

import numpy as np

from followspot.message_checks.room_fit import fit_check
from followspot.message_checks.sealing import seal
from followspot.messages import MAX_SEQ, MAX_TIME, Header, InvalidMessage, Message, stamped
from followspot.plugins.catalogue import catalogue
from followspot.plugins.registry import PluginError, load_stage
from followspot.stage import Stage
from followspot.testing.samples import BLACK, sample
from followspot.testing.tiny_room import tiny_room
from followspot.testing.trial import PERIOD, Trial
from followspot.tracking import Frame
from fuzzing.extreme import extreme_array, extreme_float, extreme_integer, extreme_text
from fuzzing.target import Target

_ROOM = tiny_room()
_LIFE = 50
"""Calls of one instance before the next takes its place."""
_ELSEWHERE = frozenset(
    {"sinks.rerun", "lsl.outlet", "dashboard.tap", "dashboard.echo", "dashboard.meter", "recording.tap"}
)
"""Stages that need a viewer or an open network, or are put at ports from outside."""


class Call(NamedTuple):
    """A call of a stage: its name, and the arguments of `process`."""

    uses: str
    arguments: list[Any]


def _message(kind: type[Message], rng: random.Random, header: Header) -> Message:
    """One of the tiny room, some of its fields at the ends of their range."""
    camera = rng.choice(list(_ROOM.cameras))
    if kind is Frame:
        shape = rng.choice(
            ((48, 64, 3), (0, 0, 3), (1, 1, 1), (5, 7, 2), (3, 4, 4), (48, 64, 1), (2, 900, 3))
        )
        pixels = np.random.default_rng(rng.randrange(1 << 30)).integers(0, 256, shape, np.uint8)
        return stamped(seal(Frame(camera, pixels)), header)
    like = sample(
        kind, rng.choice(("plausible", "empty", "unknown")), _ROOM, camera, BLACK, rng.randrange(99)
    )
    values: dict[str, Any] = {}
    for column in kind.columns:
        found = getattr(like, column.name)
        values[column.name] = extreme_array(rng, found) if rng.random() < 0.6 else found
    for name, of in kind.scalars:
        made: dict[Any, Any] = {str: extreme_text, float: extreme_float}
        extreme = made.get(of, lambda r: tuple(extreme_text(r) for _ in range(3)))
        values[name] = extreme(rng) if rng.random() < 0.1 else getattr(like, name)
    try:
        return stamped(seal(kind(**values)), header)
    except InvalidMessage:  # its texts are too long together
        return _message(kind, rng, header)


class Stages:
    """One instance of each stage, in the tiny room."""

    def __init__(self) -> None:
        self.trials = {name: trial for name in sorted(catalogue()) if (trial := _trial(name)) is not None}
        first = next(iter(_ROOM.cameras))
        self._misfits = {
            (name, port.type): fit_check(port.type, _ROOM, first if trial.stage.per_camera else None)
            for name, trial in self.trials.items()
            for port in trial.ports.inputs
        }
        self._alive: dict[str, tuple[ExitStack, Stage]] = {}
        self._calls: dict[str, int] = {}

    def make(self, rng: random.Random) -> Call:
        """Arguments for any stage; frames may come at any time."""
        uses = rng.choice(list(self.trials))
        frame = rng.randrange(1000)
        times = (frame * PERIOD, frame * PERIOD, extreme_integer(rng, -MAX_TIME, MAX_TIME))
        header = Header("fuzz", rng.choice((frame, extreme_integer(rng, 0, MAX_SEQ))), rng.choice(times), 5)
        arguments: list[Any] = []
        for port in self.trials[uses].ports.inputs:
            message = _message(port.type, rng, header)
            arguments.append((message,) if port.several else message)
        return Call(uses, arguments)

    def take(self, call: Call) -> object:
        """Call the stage. Raises InvalidMessage if an edge would have refused what it is given."""
        for argument in call.arguments:
            message = argument[0] if isinstance(argument, tuple) else argument
            ask = self._misfits[call.uses, type(message)]
            if ask is not None and (why := ask(message)):
                raise InvalidMessage(why)
        return self.trials[call.uses].called(self._instance(call.uses), call.arguments)

    def _instance(self, uses: str) -> Stage:
        calls = self._calls[uses] = self._calls.get(uses, 0) + 1
        if calls % _LIFE == 1:
            if uses in self._alive:
                self._alive.pop(uses)[0].close()
            stack = ExitStack()
            self._alive[uses] = stack, stack.enter_context(self.trials[uses].at_work())
        return self._alive[uses][1]


def _trial(name: str) -> Trial | None:
    """Messages of a stage that computes; None of other stages."""
    try:
        trial = Trial(load_stage(name), room=_ROOM)
        return trial if name not in _ELSEWHERE and trial.computes else None
    except (PluginError, ImportError):
        return None


def extreme_stage_target() -> Target:
    """Whatever a camera host may send, in the hands of every stage."""
    warnings.simplefilter("ignore")  # numpy warns of overflow
    np.seterr(all="ignore")
    logging.disable()
    sink = os.open(os.devnull, os.O_WRONLY)
    os.dup2(sink, 2)
    stages = Stages()
    return Target(stages.make, stages.take, (InvalidMessage,))
