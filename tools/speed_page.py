"""Rewrites the tables of docs/speed.md and docs/speed_causes.md: each is what the command above it prints.

    python tools/speed_page.py --rooms FOLDER                # all of them, on a machine that rests
    python tools/speed_page.py --only bench/runtime/edges bench/runtime/live_latency
    python tools/speed_page.py --list
    python tools/speed_page.py --aims

A page shows a command in a block of its own, and then its tables; this runs it with --markdown and puts
what it prints in their place. FOLDER has dev1.yaml to dev6.yaml, rooms of the development recordings with
their targets; without it the tables of commands that name them stay. The table of --machine names the
machine; that of the aims is made of all others whenever one of them is.
"""

from __future__ import annotations

import argparse
import os
import platform
import re
import shlex
import subprocess
import sys
from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from benching import speed_aims
from scripting import markdown, options_of

ROOT = Path(__file__).parent.parent
PAGES = (ROOT / "docs/speed.md", ROOT / "docs/speed_causes.md")
ROOM = re.compile(r"dev\d\.yaml")
"""A room of the folder that --rooms names."""
AIMS = "python tools/speed_page.py --aims"
_BLOCK = re.compile(
    r"^```sh\n(?P<command>python tools/(?P<tool>[\w/]+)\.py[^\n]*)\n```\n\n"
    r"(?P<tables>(?:\|[^\n]*\n|\n(?=\|))+)",
    re.MULTILINE,
)


@dataclass(frozen=True)
class Block:
    """A command of the page, the tool that it runs, and the place of its tables in the text."""

    command: str
    tool: str
    begin: int
    end: int

    @property
    def options(self) -> list[str]:
        """The options of the tool."""
        return shlex.split(self.command, comments=True)[2:]


def main() -> None:
    """Run the commands and rewrite their page after each, so that nothing is lost if one fails."""
    args = parser().parse_args()
    if args.machine:
        print(machine())
        return
    if args.aims:
        print(aims(pages()))
        return
    chosen = [block.command for block in blocks(pages()) if wanted(block, args)]
    for command in chosen:
        print(command, file=sys.stderr)
        if not args.list:
            rewrite(command, printed(command, args.rooms))
    if not args.list:
        rewrite(AIMS, aims(pages()))


def parser() -> argparse.ArgumentParser:
    """The command line."""
    options = options_of(__doc__)
    options.add_argument("--rooms", type=Path, metavar="FOLDER", help="has dev1.yaml to dev6.yaml")
    options.add_argument(
        "--only", nargs="+", metavar="TOOL", help="commands of these, as bench/runtime/edges"
    )
    options.add_argument("--list", action="store_true", help="name the commands, run none")
    options.add_argument("--machine", action="store_true", help="print the table of this machine")
    options.add_argument("--aims", action="store_true", help="print the aims beside the figures of the pages")
    options.add_argument("--markdown", action="store_true", help="as it is printed in any case")
    return options


def pages() -> str:
    """The text of all pages, one after the other."""
    return "\n".join(page.read_text(encoding="utf-8") for page in PAGES)


def blocks(text: str) -> Iterator[Block]:
    """The commands of a page that have tables right below."""
    for found in _BLOCK.finditer(text):
        yield Block(found["command"], found["tool"], *found.span("tables"))


def wanted(block: Block, args: argparse.Namespace) -> bool:
    """Whether to run this command."""
    if block.command == AIMS or (args.only is not None and block.tool not in args.only):
        return False
    return args.rooms is not None or args.list or not any(ROOM.fullmatch(word) for word in block.options)


def rewrite(command: str, tables: str) -> None:
    """Put tables below a command, on the page that has it."""
    for page in PAGES:
        text = page.read_text(encoding="utf-8")
        if any(block.command == command for block in blocks(text)):
            page.write_text(rewritten(text, command, tables), encoding="utf-8")


def printed(command: str, rooms: Path | None) -> str:
    """What a command of a page prints."""
    words = shlex.split(command, comments=True)
    if rooms is not None:
        words = [str((rooms / word).resolve()) if ROOM.fullmatch(word) else word for word in words]
    run = [sys.executable, *words[1:], "--markdown"]
    return subprocess.run(run, cwd=ROOT, check=True, stdout=subprocess.PIPE, text=True).stdout


def rewritten(text: str, command: str, tables: str) -> str:
    """The page with these tables below a command."""
    (block,) = (block for block in blocks(text) if block.command == command)
    return f"{text[: block.begin]}{tables.strip()}\n{text[block.end :]}"


def aims(text: str) -> str:
    """The aims beside what the tables of the pages tell. Raises LookupError if they lack a figure."""
    found: dict[str, list[speed_aims.Table]] = defaultdict(list)
    for block in blocks(text):
        if block.command != AIMS:
            found[block.tool] += speed_aims.tables(text[block.begin : block.end])
    return markdown(speed_aims.HEAD, list(speed_aims.aims(speed_aims.Page(found))))


def machine() -> str:
    """What this machine is, and what else it does now."""
    about = Path("/proc/cpuinfo").read_text(encoding="utf-8")
    names = re.findall(r"^model name\s*: (.+)$", about, re.MULTILINE) or [platform.machine()]
    cells: Sequence[str] = (
        names[0],
        str(len(os.sched_getaffinity(0))),
        f"{platform.python_implementation()} {platform.python_version()}",
        f"Linux {platform.release().split('-')[0]}",
        f"{os.getloadavg()[0]:.1f}",
    )
    return markdown(("processor", "cores", "Python", "system", "load before"), [cells])


if __name__ == "__main__":
    main()
