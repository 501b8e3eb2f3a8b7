"""Coverage by test, measured by pytest-cov: the tests that reach a line, and their times.

A test owns the lines that it runs itself and those of the processes that it starts, as far as they end by
themselves. Lines that run in fixtures belong to every test of the file.
"""

from __future__ import annotations

import re
import subprocess
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree

WITHOUT = ("no:cacheprovider", "no:faulthandler")
PYTEST = ("-m", "pytest", "-q", "-m", "not thorough", "--hypothesis-profile", "ci")
"""Arguments of Python."""
SOURCES = ("core", "plugins", "tools")
_CONFIG = """[run]
context = ${PYTEST_CURRENT_TEST-}
parallel = true
sigterm = true
patch = subprocess
data_file = %s
include = %s
"""
_CONTEXT = re.compile(r"(tests/.+?\.py)::(.+?)(?: \(|\|)(\w+)\)?$")
"""pytest-cov names FILE::TEST|PHASE in the process of the test, pytest FILE::TEST (PHASE) in its children."""


@dataclass(frozen=True)
class Reach:
    """seconds: of each test that passes; lines: by path and line, the tests that run it."""

    seconds: Mapping[str, float]
    lines: Mapping[str, Mapping[int, set[str]]]

    def tests(self, path: str, first: int, last: int) -> list[str]:
        """The tests for a change of these lines: the nearest by the name of their file, then the cheapest.

        A line that no test runs is run at import: all tests that reach the file are for it.
        """
        lines = self.lines.get(path, {})
        found = set().union(*(lines.get(line, ()) for line in range(first, last + 1)))
        found = found or set().union(*lines.values())
        return sorted(found, key=lambda test: (_distance(test.split("::")[0], path), self.seconds[test]))


def _distance(file: str, path: str) -> int:
    """0 if a test file has the name of a module, 1 if its folder has that of one of the module's."""
    if Path(path).stem in Path(file).stem:
        return 0
    return 1 if Path(file).parent.name in Path(path).parts else 2


def measure(root: Path, python: Path, store: Path, tests: Sequence[str]) -> Reach:
    """Run the tests of the tree at `root`, unless the store has what they reach."""
    data, times = store / "coverage", store / "times.xml"
    if not times.exists():
        store.mkdir(parents=True, exist_ok=True)
        config = store / "coveragerc"
        config.write_text(_CONFIG % (data, ",".join(f"{root / name}/*" for name in SOURCES)))
        cov = ["--cov", "--cov-context=test", f"--cov-config={config}", "--cov-report="]
        junit = [f"--junit-xml={times}", "-o", "junit_family=xunit1"]
        without = [word for name in WITHOUT for word in ("-p", name)]
        subprocess.run([python, *PYTEST, *without, *cov, *junit, *tests], cwd=root, check=False)
    return read(root, data, times)


def read(root: Path, data: Path, times: Path) -> Reach:
    """What was measured."""
    from coverage import CoverageData

    seconds, of_file = dict[str, float](), dict[str, set[str]]()
    for case in ElementTree.parse(times).iter("testcase"):  # pytest wrote it
        if not len(case):  # neither failed nor skipped
            seconds[f"{case.get('file')}::{case.get('name')}"] = float(case.get("time", 0))
            of_file.setdefault(str(case.get("file")), set()).add(f"{case.get('file')}::{case.get('name')}")
    measured = CoverageData(str(data))
    measured.read()
    lines = {}
    for path in measured.measured_files():
        by_line = {
            line: {test for context in contexts for test in _tests(context, of_file)} & seconds.keys()
            for line, contexts in measured.contexts_by_lineno(path).items()
        }
        lines[str(Path(path).relative_to(root))] = by_line
    return Reach(seconds, lines)


def _tests(context: str, of_file: Mapping[str, set[str]]) -> set[str]:
    """The tests that a context stands for; none for lines that ran at import."""
    found = _CONTEXT.match(context)
    if found is None:
        return set()
    file, test, phase = found.groups()
    return {f"{file}::{test}"} if phase in ("call", "run") else of_file.get(file, set())
