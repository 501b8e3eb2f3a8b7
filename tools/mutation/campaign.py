"""Mutation testing with cosmic-ray: change the program at random places, one at a time, and run the tests.

    make mutants                                            200 places of what carries messages and measures
    make mutants SAMPLE=20 SEED=7 MODULES="core/followspot/graph plugins/followspot_balls/kalman.py"
    python tools/mutants.py --again                         what survived, once more, with the tests of today

Each change is made in a copy of the tree (runs/mutants/tree) and meets the tests whose coverage reaches its
line, the nearest by the names of their files and the cheapest first, until one fails: at most --budget
seconds of what they usually take. A change that no test reaches has survived. Tests without end have failed,
and have a second trial with 4 times the patience, for the machine may be busy. The sample is of places in the
code, so that a package has its share by what it computes. Coverage is measured once for each state of the
tree. Ctrl-C ends it; the same command goes on where it was. Results: runs/mutants/session.sqlite (`cr-
report`, `cr-html`), and a table.
"""

from __future__ import annotations

import argparse
import hashlib
import os
import resource
import shlex
import sys
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from mutation.reach import PYTEST, WITHOUT, Reach, measure
from mutation.tree import TOKEN, end, lay

ROOT = Path(__file__).parents[2]
STORE = ROOT / "runs" / "mutants"
MODULES = (
    "core/followspot/worker",
    "core/followspot/transport",
    "core/followspot/host",
    "core/followspot/operator",
    "core/followspot/control",
    "core/followspot/security",
    "plugins/followspot_accuracy",
    "tools/commands/followspot_calibrate",
)
SLOWER, AT_LEAST_S = 5.0, 30.0
"""Time limit of the tests: a multiple of their usual time, plus a constant."""
MEMORY = 6 << 30
"""Bytes of data that a process may take: a change can make a loop endless."""
NOT_INHERITED = ("PYTHONDONTWRITEBYTECODE", "PYTHONPATH", "VIRTUAL_ENV")


def main() -> int:
    """Sample, run the changes without a result, print the table; 1 if one survived."""
    args = _arguments()
    from cosmic_ray.work_db import use_db  # needs the extra `mutants`; tests of the rest do not

    from mutation.sites import draw

    python = lay(ROOT, STORE / "tree")
    os.chdir(STORE / "tree")
    for name in NOT_INHERITED:
        os.environ.pop(name, None)
    os.environ |= {TOKEN: str(STORE), "OPENBLAS_NUM_THREADS": "1"}
    resource.setrlimit(resource.RLIMIT_DATA, (MEMORY, MEMORY))
    items = draw(_python_files(args.modules), args.sample, args.seed)
    with use_db(STORE / "session.sqlite") as session:
        known = {item.job_id for item in session.work_items}
        session.add_work_items(item for item in items if item.job_id not in known)
        done = {item.job_id: result for item, result in session.completed_work_items}
        waiting = [item for item in items if item.job_id not in done]
        waiting += [
            item for item in items if args.again and item.job_id in done and not _killed(done[item.job_id])
        ]
        try:
            reach = measure(Path.cwd(), python, STORE / _state(args.tests), args.tests) if waiting else None
            for number, item in enumerate(waiting, 1):
                done[item.job_id] = result = _try(item, reach, python, args.budget)
                session.set_result(item.job_id, result)
                print(f"{number}/{len(waiting)} {_told(item, result)}\n{result.diff}", flush=True)
        except KeyboardInterrupt:
            print("\nstopped; the same command goes on here", file=sys.stderr)
        finally:
            end(str(STORE))
    return _print_table([(item, done[item.job_id]) for item in items if item.job_id in done], len(items))


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--sample", type=int, default=200, help="how many changes (default 200)")
    parser.add_argument("--seed", type=int, default=1, help="of the sample (default 1)")
    parser.add_argument("--modules", nargs="+", action="extend", help="folders and files to change")
    parser.add_argument("--tests", nargs="+", action="extend", help="tests to use (default all)")
    parser.add_argument(
        "--budget", type=float, default=120.0, help="most seconds of tests for a change (default 120)"
    )
    parser.add_argument("--again", action="store_true", help="run once more what survived")
    given = parser.parse_args()
    given.modules, given.tests = given.modules or MODULES, given.tests or ["tests"]
    return given


def _python_files(modules: Sequence[str]) -> list[Path]:
    found = [p for m in map(Path, modules) for p in ([m] if m.suffix == ".py" else sorted(m.rglob("*.py")))]
    if not found or not all(path.exists() for path in found):
        sys.exit(f"no Python files in {' '.join(modules)}")
    return found


def _state(tests: Sequence[str]) -> str:
    """A name for the tests and all code of the tree."""
    files = sorted(
        path for name in ("core", "plugins", "tools", "tests") for path in Path(name).rglob("*.py")
    )
    total = hashlib.sha256(repr(list(tests)).encode())
    for path in files:
        total.update(str(path).encode() + path.read_bytes())
    return f"reach-{total.hexdigest()[:16]}"


def _try(item: Any, reach: Reach | None, python: Path, budget: float) -> Any:
    """Run the tests for a change, in the working directory, and again if they did not end in time."""
    from cosmic_ray.mutating import mutate_and_test

    assert reach is not None
    (mutation,) = item.mutations
    first, last = mutation.start_pos[0], mutation.end_pos[0]
    chosen = within(reach.tests(str(mutation.module_path), first, last), reach, budget)
    words = STORE / "words"
    words.write_text("\n".join(chosen))
    without = [word for name in (*WITHOUT, "no:xdist") for word in ("-p", name)]
    command = shlex.join([str(python), *PYTEST, *without, "-x", f"@{words}"]) if chosen else "true"
    limit = AT_LEAST_S + SLOWER * sum(reach.seconds[test] for test in chosen)
    for patience in (1.0, 4.0):
        result = mutate_and_test(item.mutations, command, patience * limit)
        end(str(STORE))
        if result.output != "timeout":
            break
    return result


def within(tests: Sequence[str], reach: Reach, budget: float) -> list[str]:
    """The first tests that together take no longer than the budget, s; the very first in any case."""
    chosen, spent = list(tests[:1]), 0.0
    for test in tests[1:]:
        spent += reach.seconds[test]
        if spent + reach.seconds[tests[0]] > budget:
            break
        chosen.append(test)
    return chosen


def _killed(result: Any) -> bool:
    return bool(result.is_killed)


def _told(item: Any, result: Any) -> str:
    (mutation,) = item.mutations
    state = "killed" if _killed(result) else "SURVIVED"
    return f"{mutation.module_path}:{mutation.start_pos[0]} {mutation.operator_name}: {state}"


def _print_table(results: Sequence[tuple[Any, Any]], expected: int) -> int:
    from followspot.tables.terminal import table

    total = Counter(_package(item) for item, _ in results)
    killed = Counter(_package(item) for item, result in results if _killed(result))
    rows = [(n, str(total[n]), str(killed[n]), str(total[n] - killed[n])) for n in sorted(total)]
    rows.append(("all", f"{total.total()}", f"{killed.total()}", f"{total.total() - killed.total()}"))
    print("\n" + table(("module", "changes", "killed", "survived"), rows))
    survivors = [(item, result) for item, result in results if not _killed(result)]
    for item, result in survivors:
        print(f"\n{_told(item, result)}\n{result.diff}")
    if len(results) < expected:
        print(f"\n{expected - len(results)} of {expected} changes are still to do")
    return 1 if survivors or len(results) < expected else 0


def _package(item: Any) -> str:
    path = item.mutations[0].module_path
    return "/".join(path.parts[: 3 if str(path).startswith(("core/", "tools/commands/")) else 2])
