"""Numbers cameras anew in messages of stages that know another part of the room."""

from __future__ import annotations

from dataclasses import replace
from typing import TypeVar

import numpy as np

from followspot.tracking import Candidates, Pairs

Viewed = TypeVar("Viewed", Pairs, Candidates)


def numbered(message: Viewed, cameras: tuple[str, ...]) -> Viewed:
    """The message with views that are numbers of these cameras, without rows of other cameras.

    The same message if it names these cameras.
    """
    if message.cameras == cameras or not len(message.view):
        return message
    number = np.array([cameras.index(c) if c in cameras else -1 for c in message.cameras], np.int32)
    renamed = replace(message, cameras=cameras, view=number[message.view])
    return renamed if (renamed.view >= 0).all() else renamed.where(renamed.view.min(axis=1) >= 0)
