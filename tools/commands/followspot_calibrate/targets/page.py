"""The page of `followspot calibrate targets`."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from followspot_calibrate.refine.text import HEAD as CHANGES
from followspot_calibrate.refine.text import cells, verdict
from followspot_calibrate.report import Page, Section, hue_bars, plain_table
from followspot_calibrate.targets.result import TargetsResult
from followspot_calibrate.targets.separability import CONFUSED, worst
from followspot_calibrate.targets.text import APART, HEAD, accepted_rows, template_row

HUES = "Share of the hues of what glows, red at the left; each camera has its own white balance."


def page_of(room: str, result: TargetsResult) -> Page:
    """The templates of each camera, their separability, and corrections of the cameras."""
    report = result.learnt
    problems = [f"{t}, {o.camera.name}: {o.problem}" for t, some in report.items() for o in some if o.problem]
    warnings = result.warnings + problems
    targets = "1 target" if len(report) == 1 else f"{len(report)} targets"
    summary = f"{targets} learnt" + (", told apart by colour" if result.apart and not warnings else "")
    sections = list(_sections(result))
    return Page(f"Targets of {room}", "look" if warnings else "good", summary, warnings, sections)


def _sections(result: TargetsResult) -> Iterator[Section]:
    report = result.learnt
    if (correction := result.agreement.correction) is not None:
        yield plain_table("Cameras corrected", CHANGES, cells(correction), note=verdict(correction))
    if result.apart:
        one = worst(result.apart)
        others = np.where(np.eye(len(one.targets), dtype=bool), 0.0, one.accepted).max(axis=1)
        confused = [
            name for name, share in zip(one.targets, others.tolist(), strict=True) if share >= CONFUSED
        ]
        yield plain_table(
            "Told apart", ("", *one.targets), accepted_rows(one), note=f"Share of {APART}.", marked=confused
        )
    lines = [template_row(name, one) for name, some in report.items() for one in some]
    yield plain_table("Templates", HEAD, lines)
    for name, some in report.items():
        hues = {o.camera.name: o.hue_histogram for o in some if o.hue_histogram is not None}
        if hues:
            yield hue_bars(f"Hues of {name}", hues, HUES)
