"""Promises about the state of a stage, from which a replacement carries on."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from followspot.stage import Stage
from followspot.testing.promises.work import contents
from followspot.testing.trial import Trial, noise, outputs, reason


def has_a_state_of_plain_values(trial: Trial) -> Iterator[str]:
    """A replacement in another process gets the state: numbers, text, arrays, lists and dicts."""
    if not trial.computes:
        return
    try:
        with trial.at_work() as stage:
            trial.feed(stage, range(3))
            wrong = _not_plain(stage.state())
    except Exception:
        return  # the promises about `process` report it
    if wrong is not None:
        yield f"state() holds a {type(wrong).__name__}, which does not travel"


def carries_on_from_its_state(trial: Trial) -> Iterator[str]:
    """A replacement with the checkpoint of the old stage gives the same results, bit for bit.

    The replacement gets the random generator of the old stage, too, as in `followspot verify`. The results of
    a stage with `state_lacks` may differ.
    """
    if not trial.computes or trial.stage.state is Stage.state:
        return
    try:
        with trial.at_work() as first, trial.at_work() as second:
            trial.feed(first, range(2))
            second.restore(first.state())  # the dry run of a swap
            trial.feed(first, range(2, 4))
            second.restore(first.state())
            if "rng" in first.__dict__:
                second.rng.bit_generator.state = first.rng.bit_generator.state
            for n in range(4, 7):
                inputs = trial.inputs("plausible", n, noise(n))
                pairs = zip(*(outputs(trial.called(stage, inputs)) for stage in (first, second)), strict=True)
                same = all(contents(a) == contents(b) for a, b in pairs)
                if not (same or trial.stage.state_lacks):
                    yield f"{n - 3} frames after the swap the replacement gives something else"
                    return
    except Exception as error:
        yield f"restoring its state raises {reason(error)}"


def _not_plain(value: Any) -> Any:
    """The first part that is no number, text, array, list or dict; None if all are."""
    if value is None or isinstance(value, bool | int | float | str | bytes | np.generic):
        return None
    if isinstance(value, np.ndarray):
        return None if value.dtype.kind in "biufcSU" else value
    if isinstance(value, list | tuple):
        return next((wrong for item in value if (wrong := _not_plain(item)) is not None), None)
    if isinstance(value, Mapping):
        return next(
            (wrong for item in (*value, *value.values()) if (wrong := _not_plain(item)) is not None), None
        )
    return value
