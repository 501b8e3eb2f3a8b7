"""The stages of a live run or a marked moment again, each on the messages that its recorded firings took.

Each stage is compared by itself: if all give what was recorded, so does the run, however its messages came
to each of them.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path

from followspot import Stage
from followspot.graph.output_ports import output_ports
from followspot.graph.plan import Plan
from followspot.plugins.registry import load_stage
from followspot.ports.signature import ports
from followspot_record.comparison import Compared, RunningComparison
from followspot_record.flight.passage import NO_CHECKPOINT, RepeatedStage
from followspot_recording.recording import Recording


def repeated(recording: Recording, plan: Plan, out: Path) -> tuple[list[Compared], list[str]]:
    """The result for each recorded port of stages with inputs, and what is to be said of them.

    out: folder for what the stages write. Raises FollowspotError.
    """
    rows: list[Compared] = []
    left_out: dict[tuple[str, int], list[str]] = defaultdict(list)
    forgetful = []
    fed = {edge.to_stage for edge in plan.edges}
    types = output_ports(plan)
    for stage in plan.stages:
        kind = load_stage(stage.uses)
        outputs = (f"{stage.name}.{port.name}" for port in ports(kind).outputs)
        if stage.name not in fed or not any(name in recording.ports for name in outputs):
            continue
        again = RepeatedStage(recording, plan, stage, types, out)
        found = [_compared(f"{stage.name}.{name}", one, again) for name, one in again.outputs.items()]
        if any(row.difference for row in found) and kind.state is Stage.state:
            forgetful.append(stage.name)
        if again.repeated:
            for why, count in again.left_out.items():
                left_out[why, count].append(stage.name)
        rows += found
    present = {stage.name for stage in plan.stages}
    late = [port for port in recording.ports if port.rpartition(".")[0] not in present]
    rows += [Compared(port, 0, unrepeated="its stage came or left while the file was open") for port in late]
    return rows, [*_notes(left_out), *_forgetful(forgetful)]


def _compared(port: str, output: RunningComparison, again: RepeatedStage) -> Compared:
    """The result for one port."""
    if again.repeated:
        return Compared(port, output.same, output.difference)
    reasons = sorted(again.left_out, key=NO_CHECKPOINT.__eq__)
    why = reasons[0] if reasons else "no firing of its stage is recorded"
    return Compared(port, 0, unrepeated=why)


def _notes(left_out: dict[tuple[str, int], list[str]]) -> Iterator[str]:
    """A line for each reason why firings were not repeated."""
    for (why, count), stages in left_out.items():
        said = "1 firing is" if count == 1 else f"{count} firings are"
        yield f"{', '.join(stages)}: {said} not repeated: {why}"


def _forgetful(stages: list[str]) -> Iterator[str]:
    if stages:
        have = "has" if len(stages) == 1 else "have"
        yield f"{', '.join(stages)} {have} no `state`: a memory from before the recording is not in it"
