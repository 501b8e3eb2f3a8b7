"""Starts the flight recorder of a run of a script, which an installed package brings."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager
from functools import partial

from followspot.errors import InputError
from followspot.graph.plan import Plan
from followspot.library.keep import Keep, seconds_of
from followspot.plugins.loaded_hooks import load_hooks

OnErrors = Callable[[Sequence[str]], None]
"""Takes the errors of a run, none if it succeeded."""
StartKeeping = Callable[[str], AbstractContextManager[OnErrors]]
"""Keeps a run of this name while the context is open."""


@contextmanager
def keep_nothing(run: str) -> Iterator[OnErrors]:
    """Keep nothing."""
    yield lambda errors: None


def keeping(plan: Plan, keep: str | float | Keep | None) -> StartKeeping:
    """What keeps runs of this plan; see `followspot.run`. Raises FollowspotError if it cannot be kept so."""
    if keep is None:
        return keep_nothing
    keepers = load_hooks().keepers
    if not keepers:
        raise InputError.of("nothing installed keeps runs", "install followspot as a whole")
    asked = keep if isinstance(keep, Keep) else Keep(seconds_of(str(keep), "keep"))
    keepers[0].check(plan, asked)
    return partial(keepers[0].start, plan, asked)
