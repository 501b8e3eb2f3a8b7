"""Parameters that have other names now: a plugin lists them in `former_names.yaml` beside its modules."""

from __future__ import annotations

import sys
from pathlib import Path

import yaml

from followspot.stage import Stage


def new_names(stage: type[Stage]) -> dict[str, str]:
    """New names of the stage's parameters by their old ones.

    The file has a mapping for each class of stages, which its subclasses inherit.
    """
    package = sys.modules[stage.__module__.partition(".")[0]]
    file = Path(getattr(package, "__file__", None) or "").parent / "former_names.yaml"
    table = yaml.safe_load(file.read_text()) if file.is_file() else {}
    return {old: new for kind in stage.__mro__ for old, new in table.get(kind.__name__, {}).items()}
