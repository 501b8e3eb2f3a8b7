"""Cost of one hop between two stages of one worker: a call, the ledger, the firing.

    python tools/bench/runtime/hop.py

Runs the same source and sink with and without a chain of stages that pass their input on; the difference,
divided by hops and messages, is the cost of a hop. A plain Python call of the same `process` methods is the
other side of the ratio.
"""

from __future__ import annotations

import json
import statistics
import time
from itertools import pairwise
from pathlib import Path
from tempfile import TemporaryDirectory

from followspot.graph.plan import Plan, PlannedEdge, PlannedStage, PlannedWorker
from followspot.operator.launch import local_run
from followspot.plugins.registry import load_stage, use_plugin_files
from followspot.room import Room
from followspot.worker.wiring import RunOptions
from scripting import options_of

STAGES = """
import numpy as np
from followspot import Source, Stage, StageParams, Field, at
from followspot.tracking import Blobs

class Emit(Stage):
    class Params(StageParams):
        count: int = Field(1, description="messages", unit="1")
    def process(self) -> Source[Blobs]:
        for n in range(self.params.count):
            yield at(n + 1, Blobs.empty())

class Pass(Stage):
    def process(self, blobs: Blobs) -> Blobs:
        return blobs

class Swallow(Stage):
    def process(self, blobs: Blobs) -> None:
        pass
"""


def chain(hops: int, messages: int) -> Plan:
    """Emit -> `hops` x Pass -> Swallow, all in one worker."""
    names = ["emit", *(f"pass{n}" for n in range(hops)), "swallow"]
    uses = ["bench_stages.emit", *["bench_stages.pass"] * hops, "bench_stages.swallow"]
    params = [{"count": messages}, *[{}] * (hops + 1)]
    stages = tuple(
        PlannedStage(name, name, use, values, None, "main", live=False)
        for name, use, values in zip(names, uses, params, strict=True)
    )
    edges = tuple(PlannedEdge(a, "out", b, "blobs", "reference") for a, b in pairwise(names))
    return Plan("hops", Room(), stages, edges, (PlannedWorker("main"),))


def run_seconds(hops: int, messages: int, out: Path) -> float:
    """Duration of one run, s. Raises AssertionError if the ledger does not balance."""
    report = local_run(chain(hops, messages), RunOptions(out)).execute()
    assert report.ok, report.errors
    return report.seconds


def call_seconds(hops: int, messages: int) -> float:
    """Duration of the same calls made by hand, s."""
    source = load_stage("bench_stages.emit")(count=messages)
    stages = [load_stage("bench_stages.pass")() for _ in range(hops)]
    started = time.perf_counter()
    for message in source.process():
        for stage in stages:
            message = stage.process(message)
    return time.perf_counter() - started


def main() -> None:
    """Measure in interleaved rounds and print medians."""
    parser = options_of(__doc__)
    parser.add_argument("--hops", type=int, default=20)
    parser.add_argument("--messages", type=int, default=5000)
    parser.add_argument("--rounds", type=int, default=5)
    args = parser.parse_args()
    hop, call = [], []
    with TemporaryDirectory() as folder:
        file = Path(folder) / "bench_stages.py"
        file.write_text(STAGES, encoding="utf-8")
        use_plugin_files([str(file)])
        for _ in range(args.rounds):
            with_chain = run_seconds(args.hops, args.messages, Path(folder))
            without = run_seconds(0, args.messages, Path(folder))
            hop.append((with_chain - without) / args.hops / args.messages)
            call.append(call_seconds(args.hops, args.messages) / args.hops / args.messages)
    result = {
        "hop_us": statistics.median(hop) * 1e6,
        "call_us": statistics.median(call) * 1e6,
        "ratio": statistics.median(h / c for h, c in zip(hop, call, strict=True)),
    }
    if args.json:
        print(json.dumps(result))
    else:
        print("hop {hop_us:.2f} us, plain call {call_us:.2f} us, ratio {ratio:.1f}".format(**result))


if __name__ == "__main__":
    main()
