"""Parts of a picture side by side: nothing in one may depend on what stands next to it."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.plugins.balls.scene import whole_strip

from followspot.messages import Array
from followspot_balls.detection.components import above_local_peak, components, of_size
from followspot_balls.detection.hough import disc_centers
from followspot_balls.detection.strip import Strip, abreast, clusters, cut, scattered, window_strip

SMALLEST, LARGEST = 3, 60
EDGE = 0.6


def speckled(seed: int) -> Array:
    """A dark picture with bright patches, some at its border, and single hot pixels."""
    rng = np.random.default_rng(seed)
    level = np.zeros((50, 70), np.uint8)
    for _ in range(25):
        y, x = rng.integers(0, 48), rng.integers(0, 68)
        level[y : y + rng.integers(1, 9), x : x + rng.integers(1, 9)] = rng.integers(60, 256)
    return level


def found(level: Array, strip: Strip) -> Array:
    """x, y and area of the components of allowed size, in the picture."""
    blobs = components(above_local_peak(level, EDGE), level, strip)
    one = np.zeros(len(blobs.area), int)
    fits = of_size(blobs.area, one + SMALLEST, one + LARGEST, one)
    rows = np.column_stack([blobs.center, blobs.area])[fits]
    return rows[np.lexsort(rows.T)]


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 10_000))
def test_clusters_hold_the_components_of_the_whole_picture(seed: int) -> None:
    level = speckled(seed)
    y, x = level.nonzero()
    parts = clusters(np.zeros(len(y), int), y, x, (1, *level.shape), np.array([SMALLEST]))
    strip = scattered(parts.shape, parts.place, level[y, x].take(parts.entry))
    assert found(strip, parts.strip) == pytest.approx(found(level, whole_strip(70)))


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 10_000), st.integers(1, 6))
def test_the_order_of_components_does_not_depend_on_the_column_at_which_their_part_stands(
    seed: int, left: int
) -> None:
    alone = speckled(seed)
    shifted = np.pad(alone, ((0, 0), (left, 0)))
    centers = [components(level > 0, level, whole_strip(level.shape[1])).center for level in (alone, shifted)]
    assert centers[1] - centers[0] == pytest.approx(np.full(centers[0].shape, [left, 0]))


def test_a_blob_at_the_edge_of_its_strip_has_the_center_that_it_has_elsewhere() -> None:
    wide = np.zeros((30, 30), np.uint8)
    wide[11:19, 11:19] = 200
    wide[15, 18] = 0
    tight = wide[10:20, 10:20]  # one dark pixel around it
    offset = []
    for level in (wide, tight):
        strip = whole_strip(level.shape[1])
        blobs = components(above_local_peak(level, EDGE), level, strip)
        center, _ = disc_centers(level, strip, blobs, np.array([4.0]), EDGE)
        offset.append(center - blobs.center)
    assert offset[1] == pytest.approx(offset[0], abs=1e-9)


def test_clusters_of_different_layers_are_apart() -> None:
    layer, y, x = np.array([0, 0, 1, 1]), np.array([48, 49, 0, 1]), np.array([5, 5, 5, 5])
    parts = clusters(layer, y, x, (2, 50, 70), np.array([2, 2]))
    assert parts.layer.tolist() == [0, 1]
    assert len(parts.entry) == 4
    lone = clusters(layer, y, x, (2, 50, 70), np.array([2, 3]))
    assert lone.layer.tolist() == [0]
    assert lone.entry.tolist() == [0, 1]


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 10_000), st.integers(40, 60))
def test_the_order_of_clusters_in_a_layer_does_not_depend_on_the_layers_before(seed: int, high: int) -> None:
    y, x = speckled(seed)[:40].nonzero()
    size, one = (high, 70), np.zeros(len(y), int)
    alone = clusters(one, y, x, (1, *size), np.array([SMALLEST]))
    after = clusters(one + 1, y, x, (2, *size), np.array([SMALLEST] * 2))
    assert after.place.tolist() == alone.place.tolist()
    assert after.strip.shift.tolist() == alone.strip.shift.tolist()


def test_a_window_shows_its_part_of_the_picture_and_black_beyond() -> None:
    pixels = np.arange(1, 13, dtype=np.uint8).reshape(3, 4, 1)
    windows = abreast(np.array([[-1, -1], [2, 1]]), np.array([3, 4]))
    strip = cut([pixels, pixels], windows)[..., 0]
    parts = window_strip(windows)
    for x in np.flatnonzero(strip.any(axis=0)):
        for y in strip[:, x].nonzero()[0]:
            column, row = (x, y) + parts.shift[parts.part[x]]
            assert strip[y, x] == pixels[row, column, 0]
    assert np.count_nonzero(strip) == 4 + 4


def test_a_window_looks_the_same_first_and_last_in_a_strip() -> None:
    # what the smoothing of its edge reaches is there on both sides, wherever it stands
    pixels = np.full((20, 20, 1), 200, np.uint8)
    windows = abreast(np.array([[3, 3], [8, 5]]), np.array([6, 6]))
    strip = cut([pixels, pixels], windows)[..., 0]
    shown = np.flatnonzero(strip.any(axis=0))
    assert shown[0] > 0
    assert shown[-1] < strip.shape[1] - 1
    assert len(window_strip(windows).part) == strip.shape[1]
