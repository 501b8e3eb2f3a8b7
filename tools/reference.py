"""Write docs/reference.md: every built-in stage with its ports and parameters, as it describes itself.

python tools/reference.py            write it
python tools/reference.py --check    fail if it is stale
"""

from __future__ import annotations

import argparse
import re
import sys
from collections.abc import Iterable, Mapping, Sequence
from itertools import groupby
from pathlib import Path
from typing import Any

from followspot.plugins.catalogue import catalogue
from followspot.plugins.description import describe
from followspot.plugins.registry import load_stage

PAGE = Path(__file__).parent.parent / "docs" / "reference.md"
HEAD = """# Stages

Every stage that comes with followspot, as it describes itself: `followspot plugins NAME` prints the same.
[Inputs and outputs](inputs_and_outputs.md) says what `Joined`, `Latest` and the other marks mean. This
page is written by `python tools/reference.py`.

Units: `1` is a number or a ratio, `sigma` a number of standard deviations. In a description, sigma is one
standard deviation.
"""
_FOLDERS = re.compile(r"/\S*/(?=followspot_\w+/)")
"""Path of this checkout; names of files that come with a plugin begin at the plugin."""

_GIVING = {"one": "{}", "several": "Outputs[{}]", "later": "Deferred[{}]", "lagged": "Lagged[{}]"}


def reference() -> str:
    """The whole page."""
    names = sorted(name for name, stage in catalogue().items() if stage.distribution == "followspot")
    sections = [HEAD]
    for plugin, stages in groupby(names, key=lambda name: name.partition(".")[0]):
        sections.append(f"## {plugin}\n")
        sections += [_section(describe(name, load_stage(name))) for name in stages]
    return "\n".join(sections)


def _marked(kind: str, name: str) -> str:
    """A message type as the signature of `process` has it."""
    return name if kind == "plain" else f"{kind.capitalize()}[{name}]"


def _section(stage: Mapping[str, Any]) -> str:
    inputs = [
        f"`{p['name']}: {_marked(p['kind'], p['type'])}`{'' if p['required'] else ' (optional)'}"
        for p in stage["inputs"]
    ]
    several = _GIVING[stage["gives"]]
    outputs = [f"`{p['name']}: {several.format(p['type'])}`" for p in stage["outputs"]]
    lines = [f"### {stage['name']}", "", stage["description"], ""]
    lines += [f"Takes {', '.join(inputs)}." if inputs else "A source.", ""]
    lines += [f"Gives {', '.join(outputs)}." if outputs else "A sink.", ""]
    lines += ["```yaml", stage["example"], "```", ""]
    if stage["parameters"]:
        lines += ["| parameter | default | range | unit | effect |", "|---|---|---|---|---|"]
        lines += [_row(parameter) for parameter in stage["parameters"]]
        lines.append("")
    return "\n".join(lines)


def _row(parameter: Mapping[str, Any]) -> str:
    shown = _FOLDERS.sub("", str(parameter["default"]))
    default = "required" if parameter["required"] else f"`{shown}`"
    cells: Iterable[str] = (
        f"`{parameter['name']}`",
        default,
        parameter["range"],
        parameter["unit"],
        parameter["description"],
    )
    return "| " + " | ".join(" ".join(cell.split()).replace("|", "\\|") for cell in cells) + " |"


def main(arguments: Sequence[str] | None = None) -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--check", action="store_true", help="write nothing; exit 1 if the page is stale")
    args = parser.parse_args(arguments)
    page = reference()
    if args.check:
        return int(PAGE.read_text() != page)
    PAGE.write_text(page)
    return 0


if __name__ == "__main__":
    sys.exit(main())
