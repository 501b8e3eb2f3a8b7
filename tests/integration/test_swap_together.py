"""A sub-graph of a replay is swapped in all workers at one capture time: with the bytes of one worker."""

from __future__ import annotations

from pathlib import Path

import pytest
from tests.core.graph.files import ROOM
from tests.integration.gated import GATED
from tests.integration.hosts import near_agent
from tests.integration.running import STAGES

import followspot as fs
from followspot.errors import FollowspotError

COUNT = 60
GRAPH = """
graph: whole
room: room.yaml
stages:
  eyes: {uses: room.source, each: cameras}
  hall: {graph: part.yaml, in: {frames: eyes}}
  save: {uses: held.write, in: {number: hall}}
  side: {uses: held.sum, in: {numbers: eyes}, tolerance: 0.004}
  both: {uses: held.both, in: {left: side, right: hall}, tolerance: 0.004}
  keep: {uses: held.write, in: {number: both}, with: {path: kept.csv}}
"""
PART = """
inputs: {frames: see.number}
outputs: {number: sum}
stages:
  see:  {uses: held.add, each: cameras}
  tell: {uses: held.tally, each: cameras, in: {number: see}}
  sum:  {uses: held.sum, in: {numbers: [see, tell]}, tolerance: 0.004}
"""
OTHER = """
inputs: {frames: [look.number, tell.number]}
outputs: {number: both}
stages:
  look: {uses: held.add, each: cameras, with: {term: 1000}}
  tell: {uses: held.tally, each: cameras, with: {step: 2}}
  odd:  {uses: held.odd, each: cameras, in: {number: look}}
  sum:  {uses: held.sum, in: {numbers: [odd, tell]}, tolerance: 0.004}
  mix:  {uses: held.sum, in: {numbers: look}, tolerance: 0.004}
  both: {uses: held.both, in: {left: sum, right: mix}, tolerance: 0.004}
"""


APART = """
placement: apart
workers:
  left: {host: pc-left, stages: [eyes/cam0, hall/sum, side]}
"""
"""A camera and what joins both of them on another host: each file sends both ways."""


@pytest.fixture(scope="module")
def stages(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("plugins") / "held.py"
    path.write_text(STAGES.read_text().replace("for n in range(p.count):", GATED, 1))
    return path


@pytest.fixture
def graph(tmp_path: Path) -> Path:
    """Two cameras, one 3 ms later; they send little until the output folder has a file `gate`."""
    room = ROOM.partition("targets:")[0].replace("    host: pc-left\n", "")
    for old, shift in (("frames: 20", 0), ("frames: 30", 3_000_000)):
        room = room.replace(old, f"count: {COUNT}, size: 9000, shift: {shift}")
    room = room.replace("toy.camera", "held.count")
    for name, text in {"room": room, "graph": GRAPH, "part": PART, "other": OTHER}.items():
        (tmp_path / f"{name}.yaml").write_text(text)
    return tmp_path / "graph.yaml"


def begun(
    graph: Path, stages: Path, placement: str | Path | None, network: fs.Network = fs.Network()
) -> fs.OwnRun:
    out = graph.parent / Path(placement or "one").stem
    return fs.run(graph, placement=placement, plugin_files=[stages], out=out, network=network)


def reached(run: fs.OwnRun, number: int) -> None:
    """Step the run to a number, wherever the pause has met it."""
    while run.step(1, source="eyes/cam0") < number * 10_000_000:
        pass


def there_and_back(
    graph: Path, stages: Path, placement: str | Path | None, network: fs.Network = fs.Network()
) -> tuple[bytes, bytes]:
    """What two sinks of a run have written in which the sub-graph was swapped at two capture times."""
    with begun(graph, stages, placement, network) as run:
        run.pause()
        for out in (run.out, *graph.parent.glob("runs/*")):
            (out / "gate").touch()
        reached(run, 4)
        run.swap("hall", str(graph.parent / "other.yaml"))
        run.step(9)
        run.swap("hall", str(graph.parent / "part.yaml"))
        run.resume()
        run.wait()
    assert run.report.ok
    assert not any(row["lost"] or row["in_flight"] for row in run.report.ledger)
    return (run.out / "ticks.csv").read_bytes(), (run.out / "kept.csv").read_bytes()


@pytest.mark.thorough
def test_each_camera_in_a_worker_of_its_own_gives_the_bytes_of_one_worker(graph: Path, stages: Path) -> None:
    one, kept = there_and_back(graph, stages, None)
    numbers = [int(line.split(b",")[2]) for line in one.splitlines()]
    assert len(numbers) == COUNT
    assert 0 < sum(number > 100_000 for number in numbers) < COUNT, "both files worked for a while"
    assert there_and_back(graph, stages, "camera") == (one, kept)


def test_two_hosts_give_the_bytes_of_one_worker(graph: Path, stages: Path, tmp_path: Path) -> None:
    (tmp_path / "apart.yaml").write_text(APART)
    agent = near_agent("pc-left", tmp_path, "--plugin", stages)
    try:
        network = fs.Network(connect=(agent.endpoint,))
        found = there_and_back(graph, stages, tmp_path / "apart.yaml", network)
    finally:
        agent.end()
    assert found == there_and_back(graph, stages, None)


def test_a_stage_that_cannot_begin_in_one_worker_leaves_all_as_they_were(graph: Path, stages: Path) -> None:
    broken = OTHER.replace(
        "{uses: held.odd, each: cameras,", "{uses: held.tally, each: cameras, with: {broken: true},"
    )
    (graph.parent / "broken.yaml").write_text(broken)
    with begun(graph, stages, "camera") as run:
        run.pause()
        (run.out / "gate").touch()
        with pytest.raises(FollowspotError, match="cannot be built: RuntimeError: the model is missing"):
            run.swap("hall", str(graph.parent / "broken.yaml"))
        run.resume()
        run.wait()
    assert run.report.ok
    lines = (run.out / "ticks.csv").read_text().splitlines()
    assert [int(line.split(",")[2]) for line in lines] == [4 * n + 4 for n in range(COUNT)]
