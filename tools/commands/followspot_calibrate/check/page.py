"""The page of `followspot calibrate check`."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from followspot import Room
from followspot_calibrate.check.agreement import Agreement
from followspot_calibrate.check.findings import Drift, Findings
from followspot_calibrate.check.text import AGAINST_HEAD, CAMERA_HEAD, against_rows, camera_rows
from followspot_calibrate.report import (
    Course,
    Page,
    Section,
    Verdict,
    coverage,
    drift_charts,
    pair_table,
    plain_table,
    poses,
)

CAMERA_NOTE = (
    "Each camera against the point that the others see. Gross errors (over 1 % of the picture) show "
    "something else and count in the median only; what is judged is the worst part of the time."
)
AGAINST_NOTE = (
    "The other calibration minus this one, after the similarity that most cameras agree with; pixels are of "
    "points where the cameras look."
)


def page_of(room: Room, found: Findings) -> Page:
    """All that was measured."""
    verdict: Verdict = "bad" if found.failures else "look" if found.warnings else "good"
    warnings = [*found.failures, *found.warnings]
    return Page(f"Check of {room.name}", verdict, found.verdict, warnings, list(_sections(room, found)))


def _sections(room: Room, found: Findings) -> Iterator[Section]:
    evidence = [(found.points, "Points"), (found.tracks, "Tracked targets")]
    for one, title in evidence:
        if one is not None:
            yield from _agreement(one, title, found.blamed)
    if found.length is not None:
        row = [f"{v:.2f}" for v in (1000 * found.length.true_m, found.length.mean_mm, found.length.sigma_mm)]
        head = ("true mm", "mean mm", "sigma mm", "measured")
        yield plain_table("Known length", head, [[*row, f"{found.length.count} times"]])
    if found.drifts and found.tracks is not None:
        yield drift_charts([_course(one) for one in found.drifts], float(found.tracks.limit.min()))
    if found.comparison is not None:
        scale = "" if np.isnan(found.comparison.scale) else f" Scale {found.comparison.scale:.5f}."
        rows = against_rows(found.comparison)
        yield plain_table(
            "Other calibration", AGAINST_HEAD, rows, note=AGAINST_NOTE + scale, marked=found.blamed
        )
    points = next((one.points for one, _ in evidence if one is not None), None)
    yield poses(list(room.cameras.values()), room.planes, points, found.blamed)
    for one, title in evidence:
        if one is not None:
            for number, camera in enumerate(one.cameras):
                picture = coverage(
                    camera.name, camera.size, one.pixel[:, number], one.inlier_residual[:, number]
                )
                yield replace(picture, title=f"{camera.name}: {title.lower()}")


def _agreement(one: Agreement, title: str, blamed: list[str]) -> Iterator[Section]:
    rows = [row[:-1] for row in camera_rows(one)]
    yield plain_table(f"{title}: cameras", CAMERA_HEAD[:-1], rows, note=CAMERA_NOTE, marked=blamed)
    names = [camera.name for camera in one.cameras]
    note = "Median distance of sightings from each other's epipolar line, px, and the points that both saw."
    limit = 2 * float(np.max(one.limit))
    yield pair_table(f"{title}: pairs", names, one.epipolar, one.shared, limit=limit, note=note)


def _course(one: Drift) -> Course:
    return one.course if one.change is None else replace(one.course, moved=one.change.at)
