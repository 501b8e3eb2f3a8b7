"""Coverage: the tests that reach a line, and their times; each test file runs once until it changes.

A test owns the lines that it runs itself and those of the processes that it starts, as far as they end by
themselves. Lines that run while fixtures are set up belong to every test of the file.
"""

from __future__ import annotations

import hashlib
import json
import os
import re
import resource
import shutil
import signal
import subprocess
import tempfile
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from mutation.tree import TOKEN, Mutant, Tree, end

SOURCES = ("core", "plugins", "tools")
_WITHOUT = ("no:cacheprovider", "no:xdist", "no:faulthandler")
PYTEST = ("-m", "pytest", "-q", *(word for name in ("mutation.probe", *_WITHOUT) for word in ("-p", name)))
ONLY = ("-m", "not thorough", "--hypothesis-profile", "ci")
CONFIG = """[run]
context = ${PYTEST_CURRENT_TEST-}
parallel = true
sigterm = true
data_file = %s
include = %s
"""
NOT_INHERITED = ("PYTHONDONTWRITEBYTECODE", "PYTHONPATH", "VIRTUAL_ENV")
MEMORY = 6 << 30
"""Bytes of data that a process may take: a change can make a loop endless."""
_LONGEST_S = 1800.0
_PHASE = re.compile(r" \((setup|call|teardown)\)$")


@dataclass
class Reach:
    """Coverage of one test file; seconds: of each test that passes; lines: by path and line, the tests.

    Lines of fixtures belong to `""`, because they serve every test.
    """

    file: str
    digest: str
    seconds: dict[str, float] = field(default_factory=dict)
    failed: list[str] = field(default_factory=list)
    lines: dict[str, dict[int, list[str]]] = field(default_factory=dict)

    def tests_of(self, path: str, first: int, last: int) -> set[str]:
        """The tests that run one of the lines `first` to `last`."""
        found = {
            test
            for line, tests in self.lines.get(path, {}).items()
            if first <= line <= last
            for test in tests
        }
        return set(self.seconds) if "" in found else found & set(self.seconds)


@dataclass(frozen=True)
class Run:
    """The result of one pytest process; log: of the probe; code: of its exit, None if it was killed."""

    log: list[dict[str, Any]]
    code: int | None
    out: str


def collect(tree: Tree, store: Path, files: Sequence[str]) -> list[Reach]:
    """Coverage of every test file, kept below `store` while neither it nor what it reaches changes."""
    found = []
    for number, file in enumerate(files, 1):
        kept = _kept(tree, store, file)
        if kept is None:
            print(f"coverage {number}/{len(files)}: {file}", flush=True)
            kept = _measure(tree, file)
            _keep(tree, store, kept)
        found.append(kept)
    return found


def choose(reaches: Iterable[Reach], mutant: Mutant, importers: Sequence[str]) -> list[list[str]]:
    """The tests for a change by file: the nearest by its name first, of these the cheapest.

    A line that runs at import is reached by whatever runs the code that it defines; if that has none of
    its own (constants, plain records), by whatever runs the modules in `importers`.
    """
    reaches = list(reaches)
    if mutant.scope is None:
        places = [[(mutant.path, *mutant.lines)]]
    else:
        bodies = [(mutant.path, *body) for body in mutant.scope]
        places = [bodies, [(path, 1, 1 << 30) for path in importers]]
    for wanted in places:
        found = [(reach, {t for place in wanted for t in reach.tests_of(*place)}) for reach in reaches]
        groups = [(reach, sorted(tests, key=reach.seconds.__getitem__)) for reach, tests in found if tests]
        if groups:
            groups.sort(key=lambda g: (_distance(g[0].file, mutant.path), sum(g[0].seconds[t] for t in g[1])))
            return [tests for _, tests in groups]
    return []


def _distance(file: str, path: str) -> int:
    """0 if a test file has the name of a module, 1 if its folder has that of one of the module's."""
    if Path(path).stem in Path(file).stem:
        return 0
    return 1 if Path(file).parent.name in Path(path).parts else 2


def run(
    tree: Tree,
    words: Sequence[str],
    limits: Mapping[str, float],
    env: Mapping[str, str] | None = None,
    *before: str,
) -> Run:
    """Run pytest in the copy in its own session; every process that it started is dead on return.

    limits: s, for each test; before: arguments of Python before those of pytest.
    """
    folder = Path(tempfile.mkdtemp(prefix="mutants-"))
    (folder / "words").write_text("\n".join(words))
    (folder / "limits").write_text(json.dumps(limits))
    log = folder / "log"
    own = {TOKEN: folder.name, "MUTANTS_LOG": str(log), "MUTANTS_LIMITS": str(folder / "limits")}
    inherited = {name: value for name, value in os.environ.items() if name not in NOT_INHERITED}
    command = [
        str(tree.python),
        *before,
        *PYTEST,
        *ONLY,
        f"--basetemp={folder / 't'}",
        f"@{folder / 'words'}",
    ]
    try:
        with (folder / "out").open("w+") as out:
            process = subprocess.Popen(
                command, cwd=tree.root, stdin=subprocess.DEVNULL, stdout=out, stderr=subprocess.STDOUT,
                env={**inherited, "OPENBLAS_NUM_THREADS": "1", "TMPDIR": str(folder), **own, **(env or {})},
                start_new_session=True, preexec_fn=_bounded,
            )  # fmt: skip
            try:
                code: int | None = process.wait(_LONGEST_S + sum(limits.values()))
            except subprocess.TimeoutExpired:
                code = None
            finally:
                if process.poll() is None:
                    os.killpg(process.pid, signal.SIGKILL)
                    process.wait()
                end(folder.name)
            out.seek(0)
            lines = log.read_text().splitlines() if log.exists() else []
            return Run([json.loads(line) for line in lines], code, out.read()[-20_000:])
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def _bounded() -> None:
    resource.setrlimit(resource.RLIMIT_DATA, (MEMORY, MEMORY))


def _measure(tree: Tree, file: str) -> Reach:
    with tempfile.TemporaryDirectory(prefix="mutants-coverage-") as folder:
        config = Path(folder, "coveragerc")
        include = "\n    ".join(f"{tree.root / name}/*" for name in SOURCES)
        config.write_text(CONFIG % (Path(folder, "data"), include))
        coverage = ("-m", "coverage", "run", f"--rcfile={config}")
        ran = run(tree, [file], {}, {"COVERAGE_PROCESS_START": str(config)}, *coverage)
        reach = Reach(file, "")
        for entry in ran.log:
            if entry.get("outcome") == "passed":
                reach.seconds[entry["test"]] = entry["seconds"]
            elif entry.get("outcome") == "failed":
                reach.failed.append(entry["test"])
        if not ran.log and ran.code != 5:  # 5: no test in this file
            reach.failed.append(f"{file}: {ran.out[-500:]}")
        _read_lines(tree, Path(folder), reach)
    return reach


def _read_lines(tree: Tree, folder: Path, reach: Reach) -> None:
    from coverage import CoverageData

    for part in sorted(folder.glob("data.*")):
        data = CoverageData(str(part))
        data.read()
        for measured in data.measured_files():
            lines = reach.lines.setdefault(str(Path(measured).relative_to(tree.root)), {})
            for line, contexts in data.contexts_by_lineno(measured).items():
                tests = {test for context in contexts if (test := _test(context)) is not None}
                lines[line] = sorted(tests.union(lines.get(line, [])))


def _test(context: str) -> str | None:
    """The test that a context names, "" for all of the file, None for none: lines that ran at import."""
    phase = _PHASE.search(context)
    if phase is None:
        return None
    return context[: phase.start()] if phase[1] == "call" else ""


def _path(store: Path, file: str) -> Path:
    return store / (file.replace("/", "+") + ".json")


def _digest(tree: Tree, file: str, reached: Iterable[str]) -> str:
    """Hash of the test file, the other files of its folder, and all that it reaches."""
    beside = [
        str(p.relative_to(tree.root))
        for p in (tree.root / file).parent.glob("*.py")
        if not p.name.startswith("test_")
    ]
    total = hashlib.sha256()
    for name in sorted({file, *beside, *reached}):
        path = tree.root / name
        total.update(name.encode() + (path.read_bytes() if path.exists() else b""))
    return total.hexdigest()


def _kept(tree: Tree, store: Path, file: str) -> Reach | None:
    path = _path(store, file)
    if not path.exists():
        return None
    data = json.loads(path.read_text())
    lines = {p: {int(k): v for k, v in by_line.items()} for p, by_line in data.pop("lines").items()}
    kept = Reach(**data, lines=lines)
    return kept if kept.digest == _digest(tree, file, kept.lines) else None


def _keep(tree: Tree, store: Path, reach: Reach) -> None:
    store.mkdir(parents=True, exist_ok=True)
    reach.digest = _digest(tree, reach.file, reach.lines)
    path = _path(store, reach.file)
    path.with_suffix(".new").write_text(json.dumps(vars(reach)))
    path.with_suffix(".new").replace(path)
