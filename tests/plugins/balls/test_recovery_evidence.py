"""What candidates are worth as evidence of a lost target."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from tests.plugins.balls.epipolar_pairs import candidates

from followspot_balls.association.recovery_evidence import recovery_credit

CONFIRMED, EVIDENT = np.array([True, True, False, False]), np.array([True, False, True, False])


def test_a_confirmed_candidate_counts_half_unless_it_is_evident_and_others_do_not_count() -> None:
    found = replace(candidates([0.0] * 4), confirmed=CONFIRMED, evident=EVIDENT)
    assert recovery_credit(found).tolist() == [1.0, 0.5, 0.0, 0.0]
