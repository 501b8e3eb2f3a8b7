"""Reads the parameters of stages that a room tunes."""

from __future__ import annotations

import re
from typing import Any

from followspot.errors import Mistake
from followspot.yaml.form import Form

MAX_TUNES = 1000
_TUNE = re.compile(r"[^.\s]+(\.[^.\s]+)+")


def tune_of(form: Form) -> dict[str, Any]:
    """The parameters that the room tunes, in plain values."""
    entries = form.mapping("tune")
    if len(entries) > MAX_TUNES:
        form.wrong(form.entries["tune"], f"{len(entries)} tunes, at most {MAX_TUNES} are allowed")
        return {}
    for key, node in entries.items():
        if not _TUNE.fullmatch(key):
            remedy = "write PLUGIN.STAGE.PARAMETER, STAGE.PARAMETER or STAGE/MEMBER.PARAMETER"
            form.mistakes.append(Mistake(node.key, f'"{key}" names no parameter', remedy))
    return form.values("tune")
