"""Build hook: wheels get the bundle of the page and the graphs, source distributions the bundle."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface


class BundleHook(BuildHookInterface[Any]):
    """Bundles the page and adds it to what is built; a source distribution has it already."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Called before a build. version: "editable" or "standard". Raises CalledProcessError."""
        if version == "editable":
            return
        root = Path(self.root)
        if not (root / "PKG-INFO").exists():
            subprocess.run([sys.executable, root / "tools" / "bundle.py"], check=True)
        build_data["artifacts"].append("/tools/commands/followspot_page/static/")
        if self.target_name == "wheel":
            build_data["force_include"][str(root / "graphs")] = "followspot_graphs/shipped"
