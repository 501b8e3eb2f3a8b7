"""Mutation testing: change the program at random places, one at a time, and run the tests.

    make mutants                                            200 places of what carries messages and measures
    make mutants SAMPLE=20 SEED=7 MODULES="core/followspot/graph plugins/followspot_balls/kalman.py"
    python tools/mutants.py --again                         what survived, once more, with the tests of today

Each change is made in a copy of the tree (runs/mutants/tree) and meets the tests whose coverage reaches its
line, the nearest by the names of their files and the cheapest first, until one fails: at most --files of them
and --budget seconds of what they usually take. A test without end has failed, and has a second trial with 4
times the patience, for the machine may be busy. A change that no test reaches has survived. The sample is of
places in the code, so that a package has its share by what it computes. Ctrl-C ends it; the same command goes
on where it was. Results: runs/mutants/results.jsonl, and a table.
"""

from __future__ import annotations

import argparse
import json
import re
import sys
import time
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from mutation.reach import Reach, Run, choose, collect, run
from mutation.tree import Mutant, Tree, lay

ROOT = Path(__file__).parents[2]
STORE = ROOT / "runs" / "mutants"
MODULES = (
    "core/followspot/worker",
    "core/followspot/transport",
    "core/followspot/host",
    "core/followspot/operator",
    "core/followspot/control",
    "core/followspot/security",
    "core/followspot/accuracy",
    "tools/commands/followspot_calibrate",
)
SLOWER, AT_LEAST_S = 5.0, 30.0
"""Time limit of a test: a multiple of the usual time of its file, plus a constant."""
PATIENCE = (1.0, 4.0)
"""Times that; a test that did not end has a second trial, for the machine may have been busy."""
WITHOUT_END = " (did not end)"
_IMPORT = re.compile(r"^\s*(?:from|import)\b.*$", re.MULTILINE)


@dataclass(frozen=True)
class Limits:
    """files: at most so many test files for one change; budget_s: and so many seconds of tests."""

    files: int
    budget_s: float


def main() -> int:
    """Sample, run the mutants without a result, print the table; 1 if one survived."""
    args = _arguments()
    from mutation.sites import draw, sites  # needs the extra `mutants`; tests of the rest do not

    tree = lay(ROOT, STORE / "tree")
    paths = _python_files(args.modules)
    mutants = draw(ROOT, sites(ROOT, paths), args.sample, args.seed)
    results = _results(STORE / "results.jsonl")
    again = {key for key, result in results.items() if args.again and not result["killed"]}
    todo = [m for m in mutants if m.key not in results or m.key in again]
    try:
        if todo:
            reaches = collect(tree, STORE / "coverage", _python_files(args.tests, "test_*.py"))
            _say_failed(reaches)
            _run_all(tree, todo, reaches, Limits(args.files, args.budget), results)
    except KeyboardInterrupt:
        print("\nstopped; the same command goes on here", file=sys.stderr)
    return _print_table(mutants, results)


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--sample", type=int, default=200, help="how many changes (default 200)")
    parser.add_argument("--seed", type=int, default=1, help="of the sample (default 1)")
    parser.add_argument("--modules", nargs="+", default=MODULES, help="folders and files to change")
    parser.add_argument(
        "--tests", nargs="+", default=["tests"], help="folders and files of tests to use (default all)"
    )
    parser.add_argument("--files", type=int, default=30, help="most test files for a change (default 30)")
    parser.add_argument(
        "--budget", type=float, default=120.0, help="most seconds of tests for a change (default 120)"
    )
    parser.add_argument("--again", action="store_true", help="run once more what survived")
    return parser.parse_args()


def _python_files(modules: Sequence[str], pattern: str = "*.py") -> list[str]:
    found = [
        p for m in modules for p in ([ROOT / m] if m.endswith(".py") else sorted((ROOT / m).rglob(pattern)))
    ]
    if not found or not all(path.exists() for path in found):
        sys.exit(f"no Python files in {' '.join(modules)}")
    return [str(path.relative_to(ROOT)) for path in found]


def _results(path: Path) -> dict[str, dict[str, Any]]:
    """The last result of each change."""
    lines = path.read_text().splitlines() if path.exists() else []
    return {result["key"]: result for result in map(json.loads, lines)}


def _say_failed(reaches: Sequence[Reach]) -> None:
    for test in (test for reach in reaches for test in reach.failed):
        print(f"not used, because it fails without a change: {test}")


def _run_all(
    tree: Tree,
    todo: Sequence[Mutant],
    reaches: Sequence[Reach],
    limits: Limits,
    results: dict[str, dict[str, Any]],
) -> None:
    imports = {
        str(p.relative_to(ROOT)): _IMPORT.findall(p.read_text())
        for p in map(ROOT.joinpath, _python_files(("core", "plugins", "tools")))
    }
    seconds = {test: cost for reach in reaches for test, cost in reach.seconds.items()}
    for number, mutant in enumerate(todo, 1):
        stem = re.compile(rf"\b{Path(mutant.path).stem}\b")
        importers = [
            path for path, lines in imports.items() if path != mutant.path and any(map(stem.search, lines))
        ]
        chosen = _within(choose(reaches, mutant, importers), seconds, limits)
        result = _try(tree, mutant, chosen, seconds)
        results[mutant.key] = result
        with (STORE / "results.jsonl").open("a") as file:
            file.write(json.dumps(result) + "\n")
        said = f"killed by {result['killed']}" if result["killed"] else f"SURVIVED {len(chosen)} tests"
        print(
            f"{number}/{len(todo)} {mutant.path}:{mutant.line} {mutant.operator}: {said}\n{mutant.diff}",
            flush=True,
        )


def _within(groups: Sequence[Sequence[str]], seconds: dict[str, float], limits: Limits) -> list[str]:
    """The first groups within the limits; of tests beyond the budget only the very first."""
    chosen: list[str] = []
    spent = 0.0
    for tests in groups[: limits.files]:
        for test in tests:
            if not chosen or spent + seconds[test] <= limits.budget_s:
                chosen.append(test)
                spent += seconds[test]
    return chosen


def _try(tree: Tree, mutant: Mutant, chosen: Sequence[str], seconds: dict[str, float]) -> dict[str, Any]:
    begun = time.monotonic()
    killed, out = "", ""
    for patience in PATIENCE if chosen else ():
        limits = {test: patience * (AT_LEAST_S + SLOWER * _of_file(test, seconds)) for test in chosen}
        with tree.changed(mutant):
            ran = run(tree, ["-x", *chosen], limits)
        killed, out = _verdict(ran), ran.out
        if not killed.endswith(WITHOUT_END):
            break
    return {
        "key": mutant.key, "path": mutant.path, "line": mutant.line, "operator": mutant.operator,
        "killed": killed, "tests": len(chosen), "seconds": round(time.monotonic() - begun, 1),
        "diff": mutant.diff, "out": out[-3000:] if killed else "",
    }  # fmt: skip


def _of_file(test: str, seconds: Mapping[str, float]) -> float:
    """Usual time of all tests of its file: shared fixtures may run in any of them."""
    file = test.split("::")[0] + "::"
    return sum(cost for name, cost in seconds.items() if name.startswith(file))


def _verdict(ran: Run) -> str:
    """The killer of a mutant: a test, a test without end or the import; "" if it survived.

    Raises RuntimeError if pytest did not accept its arguments, which says nothing about the mutant.
    """
    failed = [entry["test"] for entry in ran.log if entry.get("outcome") == "failed"]
    if failed:
        return str(failed[0])
    if ran.code == 0:
        return ""
    begun = [entry["begin"] for entry in ran.log if "begin" in entry]
    if not begun and not any(word in ran.out for word in ("Traceback", "ERROR collecting")):
        raise RuntimeError(f"pytest could not begin:\n{ran.out}")
    return begun[-1] + WITHOUT_END if begun else "import"


def _print_table(mutants: Sequence[Mutant], results: dict[str, dict[str, Any]]) -> int:
    done = [results[m.key] for m in mutants if m.key in results]
    killed = Counter(_package(r["path"]) for r in done if r["killed"])
    total = Counter(_package(r["path"]) for r in done)
    print(f"\n{'module':40} {'changes':>8} {'killed':>8} {'survived':>9}")
    for name in sorted(total):
        print(f"{name:40} {total[name]:8} {killed[name]:8} {total[name] - killed[name]:9}")
    share = f"{killed.total() / total.total():.1%}" if done else "-"
    print(
        f"{'all':40} {total.total():8} {killed.total():8} {total.total() - killed.total():9}   {share} killed"
    )
    survivors = [r for r in done if not r["killed"]]
    for result in survivors:
        reached = f"{result['tests']} tests" if result["tests"] else "reached by no test"
        print(f"\n{result['path']}:{result['line']}  {result['operator']}  {reached}\n{result['diff']}")
    if len(done) < len(mutants):
        print(f"\n{len(mutants) - len(done)} of {len(mutants)} changes are still to do")
    return 1 if survivors or len(done) < len(mutants) else 0


def _package(path: str) -> str:
    return "/".join(Path(path).parts[: 3 if path.startswith(("core/", "tools/commands/")) else 2])
