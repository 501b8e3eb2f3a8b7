"""`--placement auto` chooses workers by measured work, the same for the same figures, and nothing else."""

from __future__ import annotations

import dataclasses
import json
from pathlib import Path

import pytest
from tests.core.graph.files import HERE, TOY, write

from followspot.errors import InputError
from followspot.graph import placement
from followspot.graph.auto_placement.pipeline_model import HOP_WAIT, HOP_WORK, PipelineModel
from followspot.graph.auto_placement.search import Choice, PlacementUnit, choose, explained
from followspot.graph.compile import compile_graph
from followspot.graph.plan import Plan

CAMERAS = tuple(f"cam{number}" for number in range(4))


def tracker(
    detect: float, fuse: float, *, delay: int = 0, cores: int = 2, capture: float = 0.5
) -> PipelineModel:
    """Four cameras with a detector each, a fusion, feedback to the detectors if there is a delay."""
    work = {f"camera/{name}": capture for name in CAMERAS} | {f"detect/{name}": detect for name in CAMERAS}
    wires = [(f"camera/{name}", f"detect/{name}", 0) for name in CAMERAS]
    wires += [(f"detect/{name}", "fuse", 0) for name in CAMERAS]
    wires += [("fuse", f"detect/{name}", delay) for name in CAMERAS if delay]
    return PipelineModel(work | {"fuse": fuse}, wires, cores)


def units(model: PipelineModel) -> list[PlacementUnit]:
    cameras = [PlacementUnit(name, (f"camera/{name}", f"detect/{name}"), carrier=True) for name in CAMERAS]
    return [*cameras, PlacementUnit("fuse", ("fuse",))]


def in_one(model: PipelineModel) -> dict[str, str]:
    return dict.fromkeys(model.work, "main")


def shares(choice: Choice, model: PipelineModel) -> list[float]:
    """Work of each worker, ms."""
    return [
        sum(ms for name, ms in model.work.items() if choice.worker_of[name] == worker)
        for worker in choice.workers
    ]


def test_one_worker_takes_the_sum_of_the_work() -> None:
    model = tracker(3.0, 2.0)
    timing = model.timing(in_one(model))
    assert timing.period == pytest.approx(4 * 3.5 + 2.0)
    assert timing.latency == pytest.approx(4 * 3.5 + 2.0 - 0.5), "from the end of the first source on"


def test_a_chain_over_two_workers_takes_its_longer_half_and_its_hop() -> None:
    model = PipelineModel({"a": 4.0, "b": 6.0}, [("a", "b", 0)], 2)
    timing = model.timing({"a": "one", "b": "two"})
    last = 4.0 + HOP_WORK + HOP_WAIT + 32 * (6.0 + HOP_WORK)
    assert timing.period == pytest.approx(last / 32)
    assert timing.latency == pytest.approx(HOP_WAIT + 6.0 + HOP_WORK)


def test_feedback_keeps_two_workers_from_overlapping_and_a_longer_delay_lets_them() -> None:
    split = {"a": "one", "b": "two"}
    work = {"a": 5.0, "b": 5.0}
    tight, loose = (
        PipelineModel(work, [("a", "b", 0), ("b", "a", delay)], 2).timing(split) for delay in (1, 2)
    )
    assert tight.period > 10.0
    assert loose.period < 7.0


def test_more_workers_than_cores_gain_nothing() -> None:
    one, two = tracker(3.0, 0.0, cores=1), tracker(3.0, 0.0, cores=2)
    apart = {name: name.rpartition("/")[2] for name in one.work}
    assert one.timing(apart).period > sum(one.work.values())
    assert two.timing(apart).period < 0.7 * one.timing(apart).period


def test_cheap_stages_stay_in_one_worker() -> None:
    model = tracker(0.05, 0.05, capture=0.05)
    assert choose(model, units(model), "throughput").workers == ("main",)
    assert choose(model, units(model), "latency").workers == ("main",)


def test_costly_detectors_are_shared_out_by_their_work() -> None:
    model = tracker(10.0, 1.0)
    choice = choose(model, units(model), "throughput")
    first, second = shares(choice, model)
    assert abs(first - second) < 2.0
    assert choice.here.period < 0.6 * choice.alone.period
    assert all(choice.worker_of[f"camera/{name}"] == choice.worker_of[f"detect/{name}"] for name in CAMERAS)


def test_a_longer_delay_is_used_if_it_is_there() -> None:
    tight, loose = (tracker(4.0, 14.0, delay=delay) for delay in (1, 2))
    gains = [
        found.alone.period / found.here.period
        for found in (choose(model, units(model), "throughput") for model in (tight, loose))
    ]
    assert gains[1] > 1.5
    assert gains[1] > 1.2 * gains[0]


def test_the_same_figures_give_the_same_choice() -> None:
    model = tracker(3.0, 4.0, cores=3)
    first, second = (choose(model, units(model), "throughput") for _ in range(2))
    assert first == second


def test_what_is_on_another_host_stays_there() -> None:
    model = tracker(10.0, 1.0)
    far, *near = units(model)
    found = choose(model, [dataclasses.replace(far, fixed="pc-left"), *near], "throughput")
    assert {found.worker_of[name] for name in far.instances} == {"pc-left"}
    assert "pc-left" not in {found.worker_of[name] for unit in near for name in unit.instances}


def test_the_explanation_has_the_figures() -> None:
    model = tracker(10.0, 1.0)
    choice = choose(model, units(model), "throughput")
    first, second, third = explained(choice, "throughput", 2, "report.json (60 frame sets)")
    assert first.startswith("placement auto, for most throughput: 2 workers on 2 cores")
    assert f"{choice.here.period:.2f} ms a frame set" in second
    assert f"in one worker {choice.alone.period:.2f} ms" in second
    assert "delays and codecs are as written" in third


STAGES = ("camera/cam0", "camera/cam1", "detect/cam0", "detect/cam1", "pair", "track", "save")


def report(folder: Path, work: dict[str, float], frames: int = 10) -> Path:
    stages = [{"stage": name, "fired": frames, "busy_ms": ms * frames} for name, ms in work.items()]
    path = folder / "report.json"
    path.write_text(json.dumps({"frames": frames, "workers": [{"stages": stages}]}))
    return path


def planned(folder: Path, chosen: str | Path) -> Plan:
    return compile_graph(write(folder, room=HERE), placement=chosen, plugin_files=[TOY])


COSTLY = dict.fromkeys(STAGES, 0.1) | {"detect/cam0": 20.0, "detect/cam1": 20.0}


@pytest.fixture(autouse=True)
def two_cores(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(placement, "cores_here", lambda: 2)


@pytest.mark.parametrize("aim", ["auto", "auto-throughput", "auto-latency"])
def test_a_graph_is_placed_by_a_report_and_nothing_else_changes(tmp_path: Path, aim: str) -> None:
    path = report(tmp_path, COSTLY)
    alone, placed = planned(tmp_path, "stage"), planned(tmp_path, f"{aim}:{path}")
    assert placed.worker_of("detect/cam0") != placed.worker_of("detect/cam1")
    assert len(placed.workers) == 2
    assert "placement auto" in placed.notes[0]
    same = tuple(dataclasses.replace(stage, worker="") for stage in placed.stages)
    assert same == tuple(dataclasses.replace(stage, worker="") for stage in alone.stages)
    assert [(e.name, e.delay, e.codec, e.depth, e.policy) for e in placed.edges] == [
        (e.name, e.delay, e.codec, e.depth, e.policy) for e in alone.edges
    ]


def test_a_placement_file_may_choose_by_a_report_beside_it(tmp_path: Path) -> None:
    report(tmp_path, COSTLY)
    (tmp_path / "show.yaml").write_text(
        "by: auto\ncosts: report.json\naim: latency\nbudget: {camera -> track: 5 ms, camera -> save: 1 s}\n"
    )
    plan = planned(tmp_path, tmp_path / "show.yaml")
    assert "for least latency: 2 workers" in plan.notes[0]
    (warning,) = plan.warnings
    assert "show.yaml:4:10: camera -> track cannot be kept" in str(warning)
    assert "detect/cam0 works longest, 20.0 ms" in str(warning)


@pytest.mark.parametrize(
    ("chosen", "told"),
    [
        ("auto", "--placement:1:1: auto needs the measured work"),
        ("auto:none.json", "--placement:1:1: cannot read none.json"),
    ],
)
def test_auto_without_a_report_says_how_to_measure(tmp_path: Path, chosen: str, told: str) -> None:
    with pytest.raises(InputError) as error:
        planned(tmp_path, chosen)
    assert told in str(error.value)
    assert "followspot run GRAPH" in str(error.value)


@pytest.mark.parametrize("text", ["", "[]", "{}", '{"frames": 0, "workers": []}', "[" * 100_000, "\udcff"])
def test_what_is_no_report_is_refused(tmp_path: Path, text: str) -> None:
    (tmp_path / "report.json").write_bytes(text.encode(errors="surrogateescape"))
    with pytest.raises(InputError, match="is no report of a run"):
        planned(tmp_path, f"auto:{tmp_path / 'report.json'}")


def test_a_report_of_another_graph_is_refused(tmp_path: Path) -> None:
    path = report(tmp_path, {name: 1.0 for name in STAGES if name not in ("pair", "save")})
    with pytest.raises(InputError, match='has no figures of stage "pair" and 1 more'):
        planned(tmp_path, f"auto:{path}")
