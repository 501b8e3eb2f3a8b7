"""The learnt templates as tables and as JSON."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Any

import numpy as np

from followspot.tables.terminal import table
from followspot_calibrate.refine.text import as_json as correction_as_json
from followspot_calibrate.refine.text import as_text
from followspot_calibrate.targets.learning import Learnt
from followspot_calibrate.targets.result import TargetsResult
from followspot_calibrate.targets.separability import Separability, worst

HEAD = ("target", "camera", "frames", "area", "template")
CORRECTED = "the cameras contradicted each other about the targets, and were corrected (--keep-cameras: not)"
APART = "blobs of the target on the left that the template above accepts, in the worst camera"


def summary(result: TargetsResult) -> str:
    """A line per target and camera, then the separability, and corrections of cameras."""
    rows = [template_row(name, one) for name, all_ in result.learnt.items() for one in all_]
    parts = [table(HEAD, rows)]
    if result.apart:
        one = worst(result.apart)
        parts.append(f"{APART}\n{table(('', *one.targets), accepted_rows(one))}")
    if (correction := result.agreement.correction) is not None:
        parts.append(f"{CORRECTED}\n{as_text(correction)}")
    return "\n\n".join(parts)


def as_json(result: TargetsResult) -> str:
    """The learnt templates as JSON, for scripts."""
    correction = result.agreement.correction
    return json.dumps(
        {
            "targets": {
                name: {one.camera.name: _fields(one) for one in all_} for name, all_ in result.learnt.items()
            },
            "separability": {
                one.camera: {
                    "targets": one.targets,
                    "similarity": np.round(one.similarity, 4).tolist(),
                    "accepted": np.round(one.accepted, 4).tolist(),
                }
                for one in result.apart
            },
            "correction": None if correction is None else correction_as_json(correction),
            "warnings": result.warnings,
        }
    )


def accepted_rows(one: Separability) -> list[tuple[str, ...]]:
    """One line per target: which share of its blobs the template of each other one accepts."""
    return [
        (name, *("" if i == j else f"{100 * share:.0f} %" for j, share in enumerate(one.accepted[i])))
        for i, name in enumerate(one.targets)
    ]


def template_row(name: str, one: Learnt) -> Sequence[str]:
    """One row for a camera and a target, in the order of `HEAD`."""
    area = f"{one.area[0]:.0f}-{one.area[1]:.0f} px" if one.area else "-"
    template = "nothing learnt"
    if one.hue_histogram is not None:
        template = f"hue {one.hue_histogram.argmax() * 360 // len(one.hue_histogram)} deg"
    elif one.gray is not None:
        template = f"gray {one.gray[0]:.0f}-{one.gray[1]:.0f}"
    return name, one.camera.name, str(one.frames), area, template


def _fields(one: Learnt) -> dict[str, Any]:
    histogram = None if one.hue_histogram is None else one.hue_histogram.tolist()
    found = {"hue_histogram": histogram, "gray": one.gray, "area": one.area}
    return {"frames": one.frames, **found, "problem": one.problem}
