"""What a source may say about time and number: whole numbers in their range, or a clear error."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from followspot.graph.compile import compile_graph
from followspot.messages import MAX_SEQ, MAX_TIME, Message, at
from followspot.operator.launch import local_run
from followspot.worker.wiring import RunOptions

FAR = Path(__file__).parents[2] / "stages" / "far_times.py"


def run(folder: Path, stage: str, time: int, seq: int = 0) -> tuple[str, ...]:
    (folder / "g.yaml").write_text(
        f"graph: g\nstages:\n  a: {{uses: far_times.{stage}, with: {{time: {time}, seq: {seq}}}}}\n"
        "  b: {uses: far_times.last, in: {tick: a}}\n"
    )
    plan = compile_graph(folder / "g.yaml", plugin_files=[FAR])
    return local_run(plan, RunOptions(folder)).execute().errors


@pytest.mark.parametrize("stage", ["at", "stamped"])
@pytest.mark.parametrize(
    ("time", "seq"), [(MAX_TIME + 1, 0), (-MAX_TIME - 1, 0), (2**63 - 1, 0), (0, MAX_SEQ + 1)]
)
def test_a_source_out_of_range_fails_by_name(tmp_path: Path, stage: str, time: int, seq: int) -> None:
    (error,) = run(tmp_path, stage, time, seq)
    assert error.startswith("stage a failed")
    assert "out of range" in error


@pytest.mark.parametrize("time", [-MAX_TIME, MAX_TIME])
def test_the_ends_of_the_range_reach_the_sink(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], time: int
) -> None:
    assert run(tmp_path, "at", time, MAX_SEQ) == ()
    assert capsys.readouterr().out == f"{time} {MAX_SEQ}\n"


def test_whole_numbers_of_numpy_become_plain_ones_and_fractions_are_refused() -> None:
    class Tick(Message):
        value: int

    header = at(np.int64(5), Tick(1), seq=np.uint8(3)).header  # type: ignore[arg-type]  # as a stage may do
    assert type(header.time) is type(header.seq) is int
    with pytest.raises(TypeError):
        at(0.5, Tick(1))  # type: ignore[arg-type]
