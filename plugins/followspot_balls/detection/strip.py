"""Many small parts of pictures side by side in one strip, so that one call treats them all.

The parts are search windows, of one picture or several, or the clusters in which sought pixels of a whole
picture lie. Empty columns between them are so wide that the parts are independent: results in one part do not
depend on the others.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import cv2
import numpy as np

from followspot.messages import Array

REACH = 9
"""Side of the square in which the local peak is sought, px: a ball is 5 to 9 px wide."""
GAP = REACH // 2
"""Empty columns after each part, px."""
RIM = 1
"""Empty rows above and below the parts, px, so that filters see the edges of blobs there."""
BLOCK = 4
"""Side of the blocks that clusters consist of, px. Clusters are a whole block or more apart, which is out of
each other's reach."""


class Windows(NamedTuple):
    """Positions of N square windows."""

    corners: Array
    """(N, 2) int px, x and y of the upper left pixels in their pictures."""
    sides: Array
    """(N,) px."""
    start: Array
    """(N,) first column of each in the strip."""


class Strip(NamedTuple):
    """Positions of the N parts: W columns."""

    part: Array
    """(W,) part that each column belongs to."""
    shift: Array
    """(N, 2) px, from a place in the strip to that in the picture."""


class Clusters(NamedTuple):
    """E sought pixels in a strip."""

    strip: Strip
    shape: tuple[int, int]
    """Height and width of the strip, px."""
    layer: Array
    """(N,) layer that each part shows."""
    entry: Array
    """(E,) rows of the sought pixels that are in the strip; others lie in clusters that are too small."""
    place: Array
    """(E,) flat index in the strip of each of these."""


def adjoined(left: Array, top: Array, wide: Array) -> Strip:
    """Parts next to each other.

    left, top: (N,) int, the first column and row of each in its picture; wide: (N,) columns of the strip.
    """
    start = wide.cumsum() - wide
    return Strip(np.arange(len(wide)).repeat(wide), np.column_stack([left - start, top]))


def abreast(corners: Array, sides: Array) -> Windows:
    """Windows in one strip.

    The first has empty columns before it as the others have, so that its edge looks as theirs.
    """
    wide = sides + GAP
    return Windows(corners, sides, wide.cumsum() - wide + RIM)


def window_strip(windows: Windows) -> Strip:
    """The strip that they lie in."""
    wide = windows.sides + GAP
    wide[:1] += RIM
    shift = windows.corners - RIM
    shift[:, 0] += RIM - windows.start
    return Strip(np.arange(len(wide)).repeat(wide), shift)


def cut(pictures: Sequence[Array], windows: Windows) -> Array:
    """Copy windows into a strip; pixels outside their pictures are black.

    pictures: N of (H, W, C), one for each window. Returns (rows, columns, C).
    Raises ValueError for pictures of different kinds.
    """
    (channels,) = {pixels.shape[2] for pixels in pictures}
    corners, sides, start = windows
    strip = np.zeros((sides.max() + 2 * RIM, start[-1] + sides[-1] + GAP, channels), np.uint8)
    first, end = np.maximum(corners, 0), np.maximum(corners + sides[:, None], 0)
    place = first - corners + RIM
    place[:, 0] += start - RIM
    places = zip(pictures, first.tolist(), end.tolist(), place.tolist(), strict=True)
    for pixels, (left, top), (right, bottom), (column, row) in places:
        part = pixels[top:bottom, left:right]
        height, width, _ = part.shape
        strip[row : row + height, column : column + width] = part
    return strip


def at_border(row: Array, column: Array, part: Array, windows: Windows) -> Array:
    """Which pixels of a strip of windows are the outermost of their window.

    row, column: (P,) of each; part: (W,) of each column of the strip. Returns (P,) bool.
    """
    _, sides, start = windows
    outermost = np.zeros(len(part), bool)
    outermost[start] = outermost[start + sides - 1] = True
    outside = outermost.take(column)
    outside |= row == RIM
    outside |= row == (sides + (RIM - 1)).take(part).take(column)
    return outside


def row_and_column(index: Array, width: int) -> tuple[Array, Array]:
    """Row and column of flat indices in a picture of that width: (P,) each."""
    row = index // width  # numpy.divmod takes twice as long
    return row, index - row * width


def clusters(layer: Array, y: Array, x: Array, size: tuple[int, int, int], smallest: Array) -> Clusters:
    """Sought pixels of whole pictures, gathered into a strip that is much smaller than these.

    layer, y, x: (E,) of the sought pixels; size: number of layers, height and width of the pictures, px;
    smallest: (layers,) number of pixels that a cluster must have.
    """
    layers, height, width = size
    rows, columns = height // BLOCK + 2, width // BLOCK + 1  # an empty row parts the layers
    rows += rows % 2  # labels go by pairs of rows: so those of a layer do not depend on the others
    block = (layer * rows + y // BLOCK) * columns + x // BLOCK
    taken = np.zeros((layers * rows, columns), np.uint8)
    taken.reshape(-1)[block] = 1
    count, labels = cv2.connectedComponents(taken, connectivity=8, ltype=cv2.CV_32S)
    cluster = labels.reshape(-1).take(block)
    of_layer = np.zeros(count, int)
    of_layer[cluster] = layer
    large = np.bincount(cluster, minlength=count) >= smallest.take(of_layer)
    large[0] = False  # the background
    keep = large.nonzero()[0]
    part = (large.cumsum() - 1).take(cluster)
    entry = large.take(cluster).nonzero()[0]
    part, y, x = part.take(entry), y.take(entry), x.take(entry)
    top, left, bottom, right = extents(part, y, x, len(keep))
    strip = adjoined(left - RIM, top - RIM, right - left + 1 + RIM + GAP)
    shape = (int((bottom - top).max(initial=-1)) + 1 + 2 * RIM, len(strip.part))
    column, row = x - strip.shift[:, 0].take(part), y - strip.shift[:, 1].take(part)
    return Clusters(strip, shape, of_layer[keep], entry, row * shape[1] + column)


def scattered(shape: tuple[int, ...], place: Array, values: Array) -> Array:
    """A plane with these values (E,) at flat indices (E,), and 0 elsewhere."""
    plane = np.zeros(shape, values.dtype)
    plane.reshape(-1)[place] = values
    return plane


def extents(part: Array, y: Array, x: Array, count: int) -> tuple[Array, Array, Array, Array]:
    """Top, left, bottom and right of each of `count` groups of pixels: (count,) each."""
    low, high = np.full((2, count), np.iinfo(int).max), np.zeros((2, count), int)
    for row, value in enumerate((y, x)):
        np.minimum.at(low[row], part, value)
        np.maximum.at(high[row], part, value)
    return low[0], low[1], high[0], high[1]
