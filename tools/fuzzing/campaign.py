"""Fuzz everything that parses foreign data, with many thousand broken inputs.

    python tools/fuzz.py                      100,000 messages, 30,000 files and requests, 2,000 recordings
    python tools/fuzz.py --share 0.01         a hundredth of that
    python tools/fuzz.py --only graph room --seed 7

Each target runs in a process of its own with bounded memory; an input that takes more than ten seconds of
work (two for a document) or kills the process is a crash. Inputs follow from the seed, so a crash comes again
(--only, --at).
Exit code 1 if an input did anything but pass or be rejected.
"""

from __future__ import annotations

import faulthandler
import json
import mmap
import os
import random
import resource
import signal
import subprocess
import sys
import tempfile
import time
import traceback
from importlib import import_module
from pathlib import Path
from typing import Any

from fuzzing.target import MORE_MB, Outcome, Target
from scripting import options_of

TARGETS = {
    "fuzzing.wire": {"zenoh": 80_000, "ring": 20_000},
    "fuzzing.files": {"graph": 2_500, "room": 2_500, "placement": 1_500, "override": 500, "tables": 2_000}
    | {"keypoints": 500, "calibration": 1_500},
    "fuzzing.documents": {
        "graph_values": 5_000,
        "room_values": 3_500,
        "placement_values": 1_500,
        "runs": 1_500,
    },
    "fuzzing.parameters": {"parameters": 5_000},
    "fuzzing.control": {"request": 3_000, "status": 500, "registry": 500},
    "fuzzing.ring_edges": {"extreme_ring": 50_000},
    "fuzzing.zenoh_edges": {"extreme_zenoh": 50_000},
    "fuzzing.stages": {"extreme_stage": 20_000},
    "fuzzing.pictures": {"video": 1_000, "images": 1_000},
}
"""Module -> the names of its targets, and the usual number of inputs of each."""
COUNTS = {name: count for targets in TARGETS.values() for name, count in targets.items()}
_MOST_CRASHES = 20


def target(name: str) -> Target:
    """The target; the others are not imported."""
    module = next(module for module, names in TARGETS.items() if name in names)
    made: Target = getattr(import_module(module), f"{name}_target")()
    return made


def attack(name: str, seed: int, first: int, last: int, place: memoryview) -> Outcome:
    """Try inputs `first` to `last`; place: one word, the number of the input under way."""
    aim = target(name)
    outcome = Outcome()
    start = _memory_mb()
    _limit_memory(aim.most_mb)
    faulthandler.register(signal.SIGPROF, chain=True)
    for number in range(first, last):
        place[0] = number
        made = aim.make(random.Random(f"{name}:{seed}:{number}"))
        faulthandler.dump_traceback_later(aim.longest_s * 12, exit=True)
        signal.setitimer(signal.ITIMER_PROF, aim.longest_s)
        began = time.process_time()
        try:
            aim.take(made)
            outcome.accepted += 1
        except aim.rejections as error:
            outcome.refuse(error)
        except (Exception, SystemExit) as error:
            where = traceback.extract_tb(error.__traceback__)[-1]
            text = f"{number}: {type(error).__name__}: {str(error)[:200]} at {where.filename}:{where.lineno}"
            if len(outcome.crashes) < _MOST_CRASHES:
                outcome.crashes.append(text)
        outcome.slowest_s = max(outcome.slowest_s, time.process_time() - began)
        outcome.inputs += 1
    signal.setitimer(signal.ITIMER_PROF, 0)
    faulthandler.cancel_dump_traceback_later()
    outcome.whole_mb = _memory_mb()
    outcome.peak_mb = outcome.whole_mb - start
    return outcome


def besiege(name: str, seed: int, first: int, last: int) -> Outcome:
    """Attack in a process of its own, again after each death."""
    whole = Outcome()
    while first < last and len(whole.crashes) < _MOST_CRASHES:
        with tempfile.NamedTemporaryFile() as file:
            file.write(bytes(8))
            file.flush()
            words = [sys.executable, sys.argv[0], "--child", name, *map(str, (seed, first, last)), file.name]
            done = subprocess.run(
                words, capture_output=True, env={**os.environ, "OPENCV_LOG_LEVEL": "SILENT"}
            )
            number = int.from_bytes(Path(file.name).read_bytes(), sys.byteorder)
        if done.returncode == 0:
            _add(whole, json.loads(done.stdout.splitlines()[-1]))
            break
        end = done.stderr.decode(errors="replace").strip().splitlines()[-8:]
        if done.returncode == 1 and b"Timeout (" not in done.stderr:
            raise SystemExit(f"the attack on {name} cannot be made:\n" + "\n".join(end))
        whole.crashes.append(f"{number}: the process ended with {done.returncode}: {' | '.join(end)[:600]}")
        whole.inputs += number + 1 - first
        first = number + 1
    return whole


def _add(whole: Outcome, part: dict[str, Any]) -> None:
    whole.inputs += part["inputs"]
    whole.accepted += part["accepted"]
    whole.refused.update(part["refused"])
    whole.crashes += part["crashes"]
    whole.slowest_s = max(whole.slowest_s, part["slowest_s"])
    whole.peak_mb = max(whole.peak_mb, part["peak_mb"])
    whole.whole_mb = max(whole.whole_mb, part["whole_mb"])


def _memory_mb() -> float:
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def _limit_memory(most_mb: int) -> None:
    """Limit the address space; it is larger than the memory by what is reserved and not used."""
    pages, resident, *_ = map(int, Path("/proc/self/statm").read_text().split())
    page_mb = resource.getpagesize() / (1 << 20)
    more = most_mb - resident * page_mb if most_mb else MORE_MB
    limit = int((pages * page_mb + more) * (1 << 20))
    resource.setrlimit(resource.RLIMIT_AS, (limit, limit))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


def _child(words: list[str]) -> int:
    """One attack; the outcome is the last line of standard output."""
    name, seed, first, last, path = words
    os.environ["OPENBLAS_NUM_THREADS"] = "1"
    with Path(path).open("r+b") as file:
        place = memoryview(mmap.mmap(file.fileno(), 8)).cast("q")
    print(json.dumps(attack(name, int(seed), int(first), int(last), place).to_data()))
    return 0


def _tell(name: str, outcome: Outcome) -> None:
    refused = sum(outcome.refused.values())
    print(
        f"{name:<12} {outcome.inputs:>7} inputs {outcome.accepted:>7} accepted {refused:>7} refused "
        f"({len(outcome.refused)} reasons) {len(outcome.crashes)} crashes, "
        f"slowest {outcome.slowest_s:.2f} s, memory +{outcome.peak_mb:.0f} to {outcome.whole_mb:.0f} MB",
        flush=True,
    )
    for reason, count in outcome.refused.most_common(3):
        print(f"{'':<12} {count:>7} {reason}")
    for crash in outcome.crashes:
        print(f"    CRASH {crash}")


def main() -> int:
    """Entry of the script."""
    if sys.argv[1:2] == ["--child"]:
        return _child(sys.argv[2:])
    parser = options_of(__doc__)
    parser.add_argument("--only", nargs="+", action="extend", choices=COUNTS, help="targets")
    parser.add_argument("--share", type=float, default=1.0, help="of the usual number of inputs")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--at", type=int, metavar="NUMBER", help="this input alone")
    args = parser.parse_args()
    outcomes = {}
    for name in args.only or COUNTS:
        first = 0 if args.at is None else args.at
        last = max(1, round(COUNTS[name] * args.share)) if args.at is None else args.at + 1
        outcomes[name] = besiege(name, args.seed, first, last)
        if not args.json:
            _tell(name, outcomes[name])
    if args.json:
        print(json.dumps({name: outcome.to_data() for name, outcome in outcomes.items()}))
    return 1 if any(outcome.crashes for outcome in outcomes.values()) else 0
