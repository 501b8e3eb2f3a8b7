"""A copy of the tree with its own environment, for mutations.

A process that any test starts with this environment's Python sees the copy's files, whatever it does to
PYTHONPATH: the packages of the tree come first on the path, then those of the environment that runs this.
"""

from __future__ import annotations

import hashlib
import os
import shutil
import signal
import subprocess
import sys
import sysconfig
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

TOKEN = "FOLLOWSPOT_MUTANTS"
"""Names, in the environment of every process that a test starts, the run that it belongs to."""


@dataclass(frozen=True)
class Mutant:
    """A mutation of one file.

    path: from the root of the tree; line: of the mutation, from 1; lines: of the statement down to it;
    scope: for a line that runs at import, the bodies of the functions that it defines, else of all.
    """

    path: str
    operator: str
    occurrence: int
    line: int
    lines: tuple[int, int]
    scope: tuple[tuple[int, int], ...] | None
    diff: str
    code: str

    @property
    def key(self) -> str:
        """The same for the same change of the same file, whatever else changed."""
        return hashlib.sha256(f"{self.path}\0{self.code}".encode()).hexdigest()[:16]


@dataclass(frozen=True)
class Tree:
    """root: of the copy."""

    root: Path

    @property
    def python(self) -> Path:
        """The interpreter that imports from the copy."""
        return self.root / ".venv" / "bin" / "python"

    @contextmanager
    def changed(self, mutant: Mutant) -> Iterator[None]:
        """The copy with other code in one file, and then as before, times too, by which Python compiles."""
        file = self.root / mutant.path
        before, stat = file.read_text(), file.stat()
        try:
            file.write_text(mutant.code)
            yield
        finally:
            file.write_text(before)
            os.utime(file, ns=(stat.st_atime_ns, stat.st_mtime_ns))


def lay(origin: Path, root: Path) -> Tree:
    """The copy at `root` of what the tree at `origin` holds now; files that are the same stay."""
    listed = ["git", "ls-files", "--cached", "--others", "--exclude-standard", "-z"]
    names = subprocess.run(listed, cwd=origin, check=True, capture_output=True, text=True).stdout.split("\0")
    wanted = {name for name in names if name and (origin / name).is_file()}
    _drop(root, wanted)
    for name in wanted:
        target = root / name
        target.parent.mkdir(parents=True, exist_ok=True)
        if not target.exists() or target.read_bytes() != (origin / name).read_bytes():
            shutil.copy2(origin / name, target)
    _environment(root)
    beside = root.parent / "shared"
    if (origin.parent / "shared").exists() and not beside.exists():
        beside.symlink_to(origin.parent / "shared")
    return Tree(root)


def end(run: str) -> None:
    """Kill what the processes of one run left behind; each carries the run's name in its environment."""
    mark = f"{TOKEN}={run}".encode()
    for process in Path("/proc").glob("[0-9]*"):
        try:
            if mark in (process / "environ").read_bytes().split(b"\0"):
                os.kill(int(process.name), signal.SIGKILL)
        except OSError:
            continue


def _drop(root: Path, wanted: set[str]) -> None:
    for folder in ("core", "plugins", "tools", "tests"):
        for file in (root / folder).rglob("*.py"):
            if str(file.relative_to(root)) not in wanted:
                file.unlink()


def _environment(root: Path) -> None:
    venv = root / ".venv"
    if venv.exists():
        return
    subprocess.run([sys.executable, "-m", "venv", "--without-pip", str(venv)], check=True)
    ours = Path(sysconfig.get_path("purelib"))
    theirs = venv / ours.relative_to(sys.prefix)
    first = [str(root / folder) for folder in ("core", "plugins", "tools/commands", "tools")]
    (theirs / "tree.pth").write_text("\n".join([*first, f"import site; site.addsitedir({str(ours)!r})", ""]))
    for script in (Path(sys.prefix) / "bin").iterdir():
        text = script.read_bytes() if script.is_file() and not script.is_symlink() else b""
        if text.startswith(f"#!{sys.prefix}/bin/python".encode()):
            body = text.partition(b"\n")[2]
            (venv / "bin" / script.name).write_bytes(f"#!{venv}/bin/python\n".encode() + body)
            (venv / "bin" / script.name).chmod(0o755)
