"""The usual page of a calibration: cameras, if they stand, what each saw."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence

from followspot import Camera
from followspot.messages import Array
from followspot_calibrate.report.page import Page, Section, Verdict
from followspot_calibrate.report.pictures import coverage
from followspot_calibrate.report.scene import poses
from followspot_calibrate.report.tables import camera_table


def calibration_page(
    title: str,
    verdict: Verdict,
    summary: str,
    cameras: Sequence[Camera],
    pixel: Array,
    points: Array,
    residual: Array,
    *,
    planes: Mapping[str, Array] | None = None,
    warnings: Sequence[str] = (),
    marked: Collection[str] = (),
    more: Sequence[Section] = (),
) -> Page:
    """A page with the table, the scene and two pictures per camera.

    pixel: (N, C, 2) px, NaN if not seen; points: (N, 3) m; residual: (N, C, 2) px, seen minus expected, or
    (N, C) px, NaN if left out; marked: cameras to point out; more: sections after the table.
    """
    pictures = [
        coverage(camera.name, camera.size, pixel[:, number], residual[:, number])
        for number, camera in enumerate(cameras)
    ]
    table = camera_table(cameras, pixel, residual, marked)
    scene = poses(cameras, planes, points, marked)
    return Page(title, verdict, summary, warnings, [table, *more, scene, *pictures])
