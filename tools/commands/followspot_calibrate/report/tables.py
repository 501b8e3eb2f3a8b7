"""Tables of a page."""

from __future__ import annotations

from collections.abc import Collection, Sequence

import numpy as np

from followspot import Camera
from followspot.messages import Array
from followspot_calibrate.report.elements import Element, element, number
from followspot_calibrate.report.page import Section
from followspot_calibrate.report.pictures import cell_counts


def plain_table(
    title: str,
    head: Sequence[str],
    rows: Sequence[Sequence[str]],
    *,
    note: str = "",
    marked: Collection[str] = (),
) -> Section:
    """A table; rows with a marked first cell stand out."""
    lines = [
        element("tr", *(element("td", cell) for cell in row), **_class(row[0] in marked)) for row in rows
    ]
    heading = element("thead", element("tr", *(element("th", cell) for cell in head)))
    table = element("table", heading, element("tbody", *lines))
    return Section(title, [element("div", table, class_="scroll")], note)


def camera_table(
    cameras: Sequence[Camera], pixel: Array, residual: Array, marked: Collection[str] = ()
) -> Section:
    """One line per camera: its model, the number and coverage of its sightings, and their residuals.

    pixel: (N, C, 2) px, NaN if not seen; residual: (N, C, 2) or (N, C) px, NaN if left out.
    """
    length = residual if residual.ndim == 2 else np.linalg.norm(residual, axis=2)
    head = ("camera", "kind", "size px", "focal px", "points", "left out", "picture covered",
            "mean px", "median px", "95 % px", "largest px")  # fmt: skip
    rows = [_row(camera, pixel[:, number], length[:, number]) for number, camera in enumerate(cameras)]
    return plain_table("Cameras", head, rows, marked=marked)


def pair_table(
    title: str, names: Sequence[str], value: Array, count: Array, *, limit: float, note: str
) -> Section:
    """A matrix over pairs of cameras: value (C, C) px, NaN if unknown; count (C, C) of shared points.

    limit: px, value at which a cell is fully shaded.
    """
    head = element("tr", element("th"), *(element("th", name) for name in names))
    lines = [
        element(
            "tr",
            element("td", name),
            *(
                _cell(value[i, j], int(count[i, j]), limit) if i != j else element("td")
                for j in range(len(names))
            ),
        )
        for i, name in enumerate(names)
    ]
    table = element("table", element("thead", head), element("tbody", *lines), class_="pairs")
    return Section(title, [element("div", table, class_="scroll")], note)


def _row(camera: Camera, pixel: Array, length: Array) -> list[str]:
    seen, known = np.isfinite(pixel[:, 0]), length[np.isfinite(length)]
    counts = cell_counts(camera.size, pixel[seen])
    middle = (
        [known.mean(), np.median(known), np.percentile(known, 95), known.max()]
        if len(known)
        else [np.nan] * 4
    )
    return [
        camera.name,
        camera.kind,
        f"{camera.size[0]} × {camera.size[1]}",
        number(camera.matrix[0, 0], 1),
        str(int(seen.sum())),
        str(int(seen.sum()) - len(known)),
        f"{100 * (counts > 0).mean():.0f} %",
        *(number(float(value)) for value in middle),
    ]


def _cell(value: float, count: int, limit: float) -> Element:
    share = min(max(value / limit, 0.0), 1.0) if value == value else 0.0
    style = f"background: rgba(204, 61, 61, {0.45 * share**2:.2f})"
    return element("td", number(value), element("small", f"{count} points"), style=style)


def _class(marked: bool) -> dict[str, str]:
    return {"class_": "marked"} if marked else {}
