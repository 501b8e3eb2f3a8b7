"""The message types of tracking: what their makers refuse."""

from __future__ import annotations

import numpy as np
import pytest

from followspot.tracking import Candidates, Positions

CANDIDATES = Candidates.empty(targets=np.zeros((0, 3), bool))
"""Of a room with three targets."""


def fused(*target: int) -> Positions:
    return Positions.fused(
        CANDIDATES, np.array(target), np.zeros((len(target), 0), bool), np.zeros((len(target), 3))
    )


def test_a_fusion_gives_each_target_one_position_at_most() -> None:
    assert fused(2, 0).target.tolist() == [2, 0]
    assert fused().is_empty


@pytest.mark.parametrize("target", [(0, -1), (3,), (1, 1)], ids=["below 0", "beyond the last", "twice"])
def test_a_fusion_that_gives_positions_to_no_target_or_twice_is_told(target: tuple[int, ...]) -> None:
    with pytest.raises(ValueError, match="each of 0 to 2, as the room file lists them, may have one"):
        fused(*target)
