"""The commands of `followspot calibrate`."""

from __future__ import annotations

from collections.abc import Sequence

from followspot.plugins.hooks import Command, hookimpl
from followspot_calibrate.board.arguments import COMMAND as BOARD
from followspot_calibrate.check.arguments import COMMAND as CHECK
from followspot_calibrate.clocks.arguments import COMMAND as CLOCKS
from followspot_calibrate.intrinsics.arguments import COMMAND as INTRINSICS
from followspot_calibrate.planes.arguments import COMMAND as PLANES
from followspot_calibrate.refine.arguments import COMMAND as REFINE
from followspot_calibrate.targets.arguments import COMMAND as TARGETS
from followspot_calibrate.wand.arguments import COMMAND as WAND


@hookimpl
def followspot_commands() -> Sequence[Command]:
    """All calibrations, in the order in which a new room needs them."""
    return [INTRINSICS, BOARD, WAND, PLANES, TARGETS, CLOCKS, REFINE, CHECK]
