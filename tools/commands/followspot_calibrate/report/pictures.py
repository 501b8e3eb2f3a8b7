"""Pictures of one camera: its sightings, and their distances from the expected ones."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from followspot.messages import Array
from followspot_calibrate.report.elements import Element, element
from followspot_calibrate.report.page import Section

COLUMNS, ROWS = 8, 6
"""Cells of the picture for counting coverage."""
MOST_DOTS = 800
LENGTH = 0.06
"""Length of the arrow of a large residual, over the picture's width."""
SCALES = (1, 2, 5, 10, 20, 50, 100, 200, 500)
SHADE, DOT, ARROW, LEFT_OUT = "#2563c9", "#16407f", "#b3362b", "#9aa4ae"


@dataclass(frozen=True, eq=False)
class Seen:
    """Sightings of one camera: pixel (N, 2) px; residual (N, 2) px, NaN if the point was left out."""

    size: tuple[int, int]
    pixel: Array
    residual: Array

    @property
    def used(self) -> Array:
        """(N,) bool: the points that count."""
        return np.asarray(np.isfinite(self.residual).all(axis=1))

    @property
    def length(self) -> Array:
        """Lengths of the residuals that count, px."""
        return np.asarray(np.linalg.norm(self.residual[self.used], axis=1))


def cell_counts(size: tuple[int, int], pixel: Array) -> Array:
    """Points in each cell of the picture: (ROWS, COLUMNS)."""
    width, height = size
    x = np.clip(pixel[:, 0] * COLUMNS // width, 0, COLUMNS - 1).astype(int)
    y = np.clip(pixel[:, 1] * ROWS // height, 0, ROWS - 1).astype(int)
    return np.bincount(y * COLUMNS + x, minlength=ROWS * COLUMNS).reshape(ROWS, COLUMNS)


def coverage(camera: str, size: tuple[int, int], pixel: Array, residual: Array) -> Section:
    """Two pictures of one camera: its sightings, and their residuals as arrows.

    size: width and height, px; pixel: (N, 2) px, rows with NaN are not seen; residual: (N, 2) px, seen minus
    expected, or (N,) px if only the length is known; NaN for points that were left out.
    """
    arrows = residual.ndim == 2
    vector = residual if arrows else np.column_stack([residual, np.zeros(len(residual))])
    shown = np.isfinite(pixel).all(axis=1)
    if not shown.any():
        return Section(camera, [], "saw no points")
    seen = Seen(size, pixel[shown], vector[shown])
    figures = element("div", _coverage(seen), _residuals(seen, arrows), class_="pictures")
    return Section(camera, [figures])


def _coverage(seen: Seen) -> Element:
    counts = cell_counts(seen.size, seen.pixel)
    width, height = seen.size
    wide, high = width / COLUMNS, height / ROWS
    most = max(int(counts.max()), 1)
    cells = [
        element(
            "rect",
            x=_n(column * wide),
            y=_n(row * high),
            width=_n(wide),
            height=_n(high),
            fill=SHADE,
            fill_opacity=f"{0.08 + 0.3 * counts[row, column] / most:.3f}",
        )
        for row, column in np.argwhere(counts).tolist()
    ]
    radius = width / 220
    dots = [
        element("circle", cx=_n(x), cy=_n(y), r=_n(radius), fill=DOT) for x, y in _sample(seen.pixel).tolist()
    ]
    full = int((counts > 0).sum())
    caption = f"{len(seen.pixel)} points, in {full} of {counts.size} parts of the picture"
    return _figure(seen.size, [*cells, *dots], caption)


def _residuals(seen: Seen, arrows: bool) -> Element:
    width, _ = seen.size
    length, used = seen.length, seen.used
    scale = _scale(width, length)
    start, move = _sample(seen.pixel[used]), _sample(seen.residual[used]) * scale
    stroke = {"stroke": ARROW, "stroke-width": _n(width / 320), "fill": "none"}
    lone = {**stroke, "stroke": LEFT_OUT}
    if arrows:
        shapes = [
            _path([f"M{_n(x)},{_n(y)}l{_n(u)},{_n(v)}" for (x, y), (u, v) in _rows(start, move)], stroke)
        ]
        shapes += [
            element("circle", cx=_n(x), cy=_n(y), r=_n(width / 260), fill=ARROW) for x, y in start.tolist()
        ]
    else:
        shapes = [
            element("circle", cx=_n(x), cy=_n(y), r=_n(max(r, width / 400)), fill=ARROW, fill_opacity="0.35")
            for (x, y), (r, _) in _rows(start, move)
        ]
    crosses = [_cross(x, y, width / 100) for x, y in _sample(seen.pixel[~used]).tolist()]
    out = f"; {int((~used).sum())} left out (grey crosses)" if crosses else ""
    kind = "arrows" if arrows else "radii of discs"
    spread = (
        f"median {np.median(length):.2f} px, 95 % under {np.percentile(length, 95):.2f} px; {kind} × {scale}"
        if len(length)
        else "no residuals"
    )
    return _figure(seen.size, [_path(crosses, lone), *shapes], spread + out)


def _figure(size: tuple[int, int], shapes: list[Element], caption: str) -> Element:
    picture = element("svg", *shapes, viewBox=f"0 0 {size[0]} {size[1]}", role="img")
    return element("figure", picture, element("figcaption", caption))


def _cross(x: float, y: float, side: float) -> str:
    a, b = _n(2 * side), _n(-2 * side)
    return f"M{_n(x - side)},{_n(y - side)}l{a},{a}m0,{b}l{b},{a}"


def _path(parts: list[str], style: dict[str, str]) -> Element:
    return element("path", d="".join(parts) or "M0,0", **style)


def _scale(width: int, length: Array) -> int:
    """Magnification of the drawn residuals."""
    large = float(np.percentile(length, 95)) if len(length) else 1.0
    fitting = [scale for scale in SCALES if scale * large <= LENGTH * width]
    return fitting[-1] if fitting else SCALES[0]


def _sample(rows: Array) -> Array:
    return np.asarray(rows[:: max(1, -(-len(rows) // MOST_DOTS))])


def _rows(a: Array, b: Array) -> zip[tuple[list[float], list[float]]]:
    return zip(a.tolist(), b.tolist(), strict=True)


def _n(value: float) -> str:
    return f"{value:.1f}"
