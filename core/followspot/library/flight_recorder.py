"""Starts the flight recorder of a run of a script, which an installed package brings."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager
from functools import partial

from followspot.errors import InputError
from followspot.graph.plan import Plan
from followspot.library.keep_options import Keep, seconds_of
from followspot.plugins.loaded_hooks import load_hooks

OnErrors = Callable[[Sequence[str]], None]
"""Takes the errors of a run, none if it succeeded."""
StartRecorder = Callable[[str], AbstractContextManager[OnErrors]]
"""Records a run of this name while the context is open."""


@contextmanager
def no_recorder(run: str) -> Iterator[OnErrors]:
    """Record nothing."""
    yield lambda errors: None


def recorder_of(plan: Plan, keep: str | float | Keep | None) -> StartRecorder:
    """The flight recorder of runs of this plan; see `followspot.run`. Raises FollowspotError."""
    if keep is None:
        return no_recorder
    keepers = load_hooks().keepers
    if not keepers:
        raise InputError.of("nothing installed keeps runs", "install followspot as a whole")
    asked = keep if isinstance(keep, Keep) else Keep(seconds_of(str(keep), "keep"))
    keepers[0].check(plan, asked)
    return partial(keepers[0].start, plan, asked)
