"""Hue histograms and their similarity (Jin & Qian 2008, sections 2.1 and 3.2)."""

from __future__ import annotations

import numpy as np
import pytest

from followspot_balls.detection.hue import BIT, bhattacharyya, hue_bits, normalised


def test_bhattacharyya_by_hand() -> None:
    a, b = np.zeros(16), np.zeros(16)
    a[[0, 1]], b[[1, 2]] = 0.5, [0.5, 0.5]
    assert bhattacharyya(a, b) == pytest.approx(0.5)
    assert bhattacharyya(a, a) == pytest.approx(1.0)
    assert bhattacharyya(a, np.eye(16)[0]) == pytest.approx(np.sqrt(0.5))


def test_histograms_are_normalised_and_an_empty_one_stays_zero() -> None:
    counts = np.zeros((2, 16))
    counts[0, [2, 5]] = [1, 3]
    assert normalised(counts)[0, [2, 5]] == pytest.approx([0.25, 0.75])
    assert not normalised(counts)[1].any()


def test_a_hue_has_the_bit_of_its_bin() -> None:
    histograms = np.random.default_rng(0).dirichlet(np.ones(16), 5)
    bits = hue_bits(histograms, 0.05)
    assert ((BIT[:16] & bits[:, None] > 0) == (histograms >= 0.05)).all()


def test_an_overexposed_core_may_be_of_any_hue() -> None:
    assert (BIT[16] & hue_bits(np.eye(16), 0.05)).all()
