"""Target: stages with extreme parameters that they accept, set up and given a frame."""

from __future__ import annotations

import contextlib
import io
import random
import warnings
from functools import cache
from itertools import islice
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from followspot.errors import FollowspotError, InputError, Mistake, Place
from followspot.graph.parameters import validated
from followspot.library.sink import SINK
from followspot.operating_system.temporary_folder import TemporaryFolder
from followspot.plugins.catalogue import catalogue
from followspot.plugins.registry import load_stage
from followspot.testing.samples import Content
from followspot.testing.trial import Trial
from followspot.yaml.node import node_of
from fuzzing.target import Target
from fuzzing.trees import Raw, extreme, extreme_like

_FRAMES = 2
_CONTENTS: tuple[Content, ...] = ("plausible", "empty")


@cache
def _pictures() -> TemporaryFolder:
    """A folder with a frame, for as long as the process."""
    made = TemporaryFolder("fuzz")
    cv2.imwrite(str(made.path / "frame0.png"), np.zeros((48, 64, 3), np.uint8))
    return made


def parameters_target() -> Target:
    """Stages that need no device and no reader elsewhere, each with one to three extreme parameters."""
    given = {"cameras.images": {"path": _pictures().path}}
    trials = [Trial(load_stage(name), given.get(name, {})) for name in catalogue() if name != SINK]
    usable = [trial for trial in trials if trial.complete and not (trial.stage.live or trial.stage.tap)]

    def make(rng: random.Random) -> Trial:
        trial = rng.choice(usable)
        fields = trial.stage.Params.model_fields
        names = [name for name in fields if name not in trial.params]
        changed = {
            name: _value(fields[name].get_default(call_default_factory=True), rng)
            for name in rng.sample(names, min(len(names), rng.choice((1, 1, 2, 3))))
        }
        return Trial(trial.stage, {**trial.params, **changed})

    return Target(make, _work, (FollowspotError,))


def _value(default: Any, rng: random.Random) -> Any:
    """An extreme value that Python has; most of the kind of the default."""
    while True:
        value = extreme_like(default, rng) if rng.random() < 0.9 else extreme(rng)
        if isinstance(value, bool | int | float | str | None) or (
            isinstance(value, list) and not any(isinstance(item, Raw) for item in value)
        ):
            return value


def _work(trial: Trial) -> object:
    """Check the parameters as a graph's are, then set the stage up and give it frames or take some of it."""
    place, mistakes = Place("--set", 1, 1), list[Mistake]()
    nodes = {name: node_of(_plain(value), place) for name, value in trial.params.items()}
    validated(trial.stage, "a stage", nodes, place, mistakes)
    if mistakes:
        raise InputError(mistakes)
    with warnings.catch_warnings(), contextlib.redirect_stdout(io.StringIO()), trial.at_work() as stage:
        warnings.simplefilter("ignore")
        if trial.ports.source:
            return list(islice(stage.process(), _FRAMES))
        return [stage.process(*trial.inputs(content, frame)) for frame, content in enumerate(_CONTENTS)]


def _plain(value: Any) -> Any:
    return str(value) if isinstance(value, Path) else value
