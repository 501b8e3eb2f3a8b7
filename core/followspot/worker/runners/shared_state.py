"""What the stages of a worker share by accident, kept from changing their results.

Which stages share a worker is up to the placement, which never changes a result.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from followspot.message_checks.outputs import WrongOutput
from followspot.messages import Message
from followspot.stage import Stage

WATCHED = 32
"""Number of first firings of a stage after which its inputs are checked: a stage that writes to them does so
from the beginning, and later firings need not pay for the check."""


def begin_with_default_errors() -> None:
    """Set numpy's handling of floating-point errors back: the module of a stage may have changed it."""
    np.seterr(divide="warn", over="warn", under="ignore", invalid="warn")


def keep_errors(stage: Stage, before: Mapping[str, Any]) -> None:
    """Set numpy's handling of floating-point errors back to this, with a warning, if `setup` changed it."""
    if np.geterr() != before:
        np.seterr(**before)
        stage.context.warn(
            "its setup called np.seterr, which other stages of the worker would share, so it has no effect: "
            "write `with np.errstate(...)` in process"
        )


def check_read_only(arguments: Sequence[object]) -> None:
    """Raise WrongOutput if an array of a message among inputs is writeable: the stage made it so."""
    for argument in arguments:
        for message in argument if isinstance(argument, tuple) else (argument,):
            if isinstance(message, Message):
                _check(message)


def _check(message: Message) -> None:
    values = message.__dict__
    for name in message.array_names:
        if values[name].flags.writeable:
            raise WrongOutput(
                f"made {name} of its input writeable, which other stages read, too: change a copy of it, "
                f"{name}.copy()"
            )
