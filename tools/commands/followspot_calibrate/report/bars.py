"""Small charts of a few values: hues of a template, values with their uncertainty."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from followspot.messages import Array
from followspot_calibrate.report.elements import Element, element
from followspot_calibrate.report.page import Section

WIDTH, HEIGHT = 1000, 120
LEFT, LINE = 120, 28


def hue_bars(title: str, histograms: Mapping[str, Array], note: str = "") -> Section:
    """One figure per camera: the share of each hue, (B,) over the circle, as bars of that hue."""
    figures = [_hues(name, histogram) for name, histogram in histograms.items()]
    return Section(title, [element("div", *figures, class_="charts")], note)


def interval_chart(
    title: str, names: Sequence[str], value: Array, sigma: Array, unit: str, note: str
) -> Section:
    """One line per name: a value and two sigmas to both sides of it, (C,) each."""
    reach = max(float(np.max(np.abs(value) + 2 * sigma)), 1e-9)
    middle, half = (LEFT + WIDTH) / 2, (WIDTH - LEFT) / 2 - 70
    height = LINE * len(names)
    shapes = [element("line", x1=middle, x2=middle, y1=0, y2=height, stroke="#b9c1ca")]
    for row, (name, mean, error) in enumerate(zip(names, value.tolist(), sigma.tolist(), strict=True)):
        x, y, bar = middle + half * mean / reach, LINE * (row + 0.5), half * 2 * error / reach
        shapes += [
            element("text", name, x=LEFT - 10, y=y + 4, text_anchor="end"),
            element("path", d=f"M{x - bar:.1f},{y:.1f}h{2 * bar:.1f}", stroke="#2563c9", stroke_width=3),
            element("circle", cx=f"{x:.1f}", cy=f"{y:.1f}", r=5, fill="#2563c9"),
            element("text", f"{mean:+.2f} {unit}", x=WIDTH - 60, y=y + 4),
        ]
    picture = element("svg", *shapes, viewBox=f"0 0 {WIDTH} {height}", role="img")
    return Section(title, [element("div", element("figure", picture), class_="charts")], note)


def _hues(name: str, histogram: Array) -> Element:
    step = WIDTH / len(histogram)
    top = max(float(histogram.max()), 1e-9)
    bars = [
        element(
            "rect",
            x=f"{number * step + 1:.1f}",
            y=f"{HEIGHT * (1 - share / top):.1f}",
            width=f"{step - 2:.1f}",
            height=f"{HEIGHT * share / top:.1f}",
            fill=f"hsl({360 * (number + 0.5) / len(histogram):.0f}, 75%, 50%)",
        )
        for number, share in enumerate(histogram.tolist())
    ]
    bars.append(element("path", d=f"M0,{HEIGHT}h{WIDTH}", stroke="#b9c1ca"))
    picture = element("svg", *bars, viewBox=f"0 0 {WIDTH} {HEIGHT}", role="img")
    return element("figure", element("figcaption", element("b", name)), picture)
