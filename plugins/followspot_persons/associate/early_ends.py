"""Warning of cameras whose detections end before those of the others."""

from __future__ import annotations

from collections.abc import Mapping

from followspot.frame_times import to_ns, to_seconds

EARLY = to_ns(1.0)
"""Time before the last message of all by which a camera must end for a warning, ns."""


def early_end_warning(last: Mapping[str, int]) -> str:
    """A warning that names such cameras; empty if there are none.

    last: time of the last message of each, ns.
    """
    end = max(last.values(), default=0)
    early = [f"{name} ({to_seconds(time):.2f} s)" for name, time in last.items() if end - time >= EARLY]
    if not early:
        return ""
    return (
        f"detections of {', '.join(early)} end before those of the others ({to_seconds(end):.2f} s): files"
        " may be cut off, or have no entry where nobody was seen; from there on others follow the people"
    )
