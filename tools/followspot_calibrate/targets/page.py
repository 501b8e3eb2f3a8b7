"""The page of `followspot calibrate targets`."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from followspot_calibrate.report import Page, Section, hue_bars, plain_table
from followspot_calibrate.targets.learning import Lesson
from followspot_calibrate.targets.separability import CONFUSED, Separability, worst
from followspot_calibrate.targets.text import APART, HEAD, accepted_rows, template_row

HUES = "Share of the hues of what glows, red at the left; each camera has its own white balance."


def page_of(room: str, report: Mapping[str, Sequence[Lesson]], apart: Sequence[Separability]) -> Page:
    """What each camera learnt of each target, and whether the targets can be told apart."""
    problems = [f"{t}, {o.camera.name}: {o.problem}" for t, some in report.items() for o in some if o.problem]
    warnings = [text for one in apart for text in one.warnings] + problems
    targets = "1 target" if len(report) == 1 else f"{len(report)} targets"
    summary = f"{targets} learnt" + (", told apart by colour" if apart and not warnings else "")
    sections = list(_sections(report, apart))
    return Page(f"Targets of {room}", "look" if warnings else "good", summary, warnings, sections)


def _sections(report: Mapping[str, Sequence[Lesson]], apart: Sequence[Separability]) -> Iterator[Section]:
    if apart:
        one = worst(apart)
        others = np.where(np.eye(len(one.targets), dtype=bool), 0.0, one.accepted).max(axis=1)
        confused = [
            name for name, share in zip(one.targets, others.tolist(), strict=True) if share >= CONFUSED
        ]
        yield plain_table(
            "Told apart", ("", *one.targets), accepted_rows(one), note=f"Share of {APART}.", marked=confused
        )
    lines = [template_row(name, one) for name, lessons in report.items() for one in lessons]
    yield plain_table("Templates", HEAD, lines)
    for name, lessons in report.items():
        hues = {o.camera.name: o.hue_histogram for o in lessons if o.hue_histogram is not None}
        if hues:
            yield hue_bars(f"Hues of {name}", hues, HUES)
