"""Charts over time: how far each camera's sightings are from what the other cameras expect."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from followspot.messages import Array
from followspot_calibrate.report.elements import Element, element
from followspot_calibrate.report.page import Section

WIDTH, HEIGHT = 1000, 120
LEFT, BOTTOM, TOP = 60, 22, 8
INKS = ("#2563c9", "#c9661b")
"""Across and down."""


@dataclass(frozen=True, eq=False)
class Course:
    """The bias of one camera over time.

    time: (W,) s; bias: (W, 2) px, across and down, NaN if unknown; sigma: (W,) px, of the bias;
    moved: s, since when the camera stands elsewhere, None if it does not.
    """

    camera: str
    time: Array
    bias: Array
    sigma: Array
    moved: float | None = None


def drift_charts(courses: Sequence[Course], limit: float) -> Section:
    """One chart per camera, all with the same scale; limit: px, drawn as a band."""
    largest = max((float(np.nanmax(np.abs(c.bias), initial=0.0)) for c in courses), default=0.0)
    scale = max(largest, 1.5 * limit)
    note = (
        f"Bias against the other cameras over time, px: across blue, down orange; the band is ±{limit:.1f} "
        "px, the scale is the same for all. A step is a camera that was moved, a slope one that sags."
    )
    figures = [_chart(course, limit, scale) for course in courses]
    return Section("Drift", [element("div", *figures, class_="charts")], note)


def _chart(course: Course, limit: float, scale: float) -> Element:
    start, end = (float(course.time[0]), float(course.time[-1])) if len(course.time) else (0.0, 1.0)

    def x(time: float) -> float:
        return LEFT + (WIDTH - LEFT - 10) * (time - start) / max(end - start, 1e-9)

    def y(value: float) -> float:
        return TOP + (HEIGHT - TOP - BOTTOM) * (0.5 - 0.5 * value / scale)

    shapes = [
        element("rect", x=LEFT, y=f"{y(limit):.1f}", width=WIDTH - LEFT - 10,
                height=f"{y(-limit) - y(limit):.1f}", fill="#eef2f6"),
        element("line", x1=LEFT, x2=WIDTH - 10, y1=f"{y(0):.1f}", y2=f"{y(0):.1f}", stroke="#b9c1ca"),
    ]  # fmt: skip
    for axis, ink in enumerate(INKS):
        known = np.flatnonzero(np.isfinite(course.bias[:, axis]))
        spots = [(x(course.time[i]), y(course.bias[i, axis]), course.sigma[i]) for i in known.tolist()]
        line = "M" + "L".join(f"{a:.1f},{b:.1f}" for a, b, _ in spots) if spots else "M0,0"
        bars = "".join(f"M{a:.1f},{b - _bar(s, scale):.1f}v{2 * _bar(s, scale):.1f}" for a, b, s in spots)
        shapes.append(element("path", d=bars or "M0,0", stroke=ink, stroke_opacity="0.35", stroke_width=3))
        shapes.append(element("path", d=line, stroke=ink, stroke_width=2, fill="none"))
    if course.moved is not None:
        at = f"{x(course.moved):.1f}"
        shapes.append(element("line", x1=at, x2=at, y1=TOP, y2=HEIGHT - BOTTOM, stroke="#cc3d3d",
                              stroke_width=2, stroke_dasharray="5 4"))  # fmt: skip
    for value in (-scale, 0.0, scale):
        text = f"{value:+.1f}" if value else "0 px"
        shapes.append(element("text", text, x=LEFT - 8, y=f"{y(value) + 4:.1f}", text_anchor="end"))
    for time, anchor in ((start, "start"), (end, "end")):
        shapes.append(element("text", f"{time:.1f} s", x=f"{x(time):.1f}", y=HEIGHT - 5, text_anchor=anchor))
    moved = "" if course.moved is None else f": moved at {course.moved:.1f} s"
    picture = element("svg", *shapes, viewBox=f"0 0 {WIDTH} {HEIGHT}", role="img")
    return element("figure", element("figcaption", element("b", course.camera), moved), picture)


def _bar(sigma: float, scale: float) -> float:
    """Half the height of the error bar of one sigma, px of the picture."""
    return (HEIGHT - TOP - BOTTOM) / 2 * min(sigma / scale, 1.0) if sigma == sigma else 0.0
