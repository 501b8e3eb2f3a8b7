"""A copy of the tree with its own environment, for mutations.

A process that any test starts with this environment's Python sees the copy's files, whatever it does to
PYTHONPATH: the packages of the tree come first on the path, then those of the environment that runs this.
"""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
import sysconfig
from pathlib import Path

TOKEN = "FOLLOWSPOT_MUTANTS"
"""In the environment of every process that a test starts; its value names the copy."""


def lay(origin: Path, root: Path) -> Path:
    """Copy what the tree at `origin` holds now to `root`; the Python that imports from the copy."""
    listed = ["git", "ls-files", "--cached", "--others", "--exclude-standard", "-z"]
    names = subprocess.run(listed, cwd=origin, check=True, capture_output=True, text=True).stdout.split("\0")
    for folder in ("core", "plugins", "tools", "tests"):
        shutil.rmtree(root / folder, ignore_errors=True)
    for name in names:
        if name and (origin / name).is_file():
            (root / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(origin / name, root / name)
    beside = root.parent / "shared"
    if (origin.parent / "shared").exists() and not beside.exists():
        beside.symlink_to(origin.parent / "shared")
    venv = root / ".venv"
    if not venv.exists():
        _make_environment(root, venv)
    return venv / "bin" / "python"


def end(run: str) -> None:
    """Kill what the tests of a run left behind."""
    mark = f"{TOKEN}={run}".encode()
    for process in Path("/proc").glob("[0-9]*"):
        try:
            if int(process.name) != os.getpid() and mark in (process / "environ").read_bytes().split(b"\0"):
                os.kill(int(process.name), signal.SIGKILL)
        except OSError:
            continue


def _make_environment(root: Path, venv: Path) -> None:
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
