"""followspot in a script: graphs are composed, checked and run, and a run is held by a handle."""

from __future__ import annotations

import asyncio
import inspect
import re
import signal
import subprocess
import sys
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import followspot as fs
import followspot.library.run as run_module
from followspot.errors import FollowspotError
from followspot.graph.compile import compile_graph
from followspot.graph.plan_data import plan_to_data
from followspot.tracking import Blobs, Tracks

GRAPH = Path(__file__).parents[3] / "graphs" / "glowballs.yaml"
ROOM = GRAPH.parent / "rooms" / "simulated.yaml"
TICKS = Path(__file__).parents[2] / "stages" / "ticks.py"
ENDLESS = """
graph: endless
stages:
  a: {uses: ticks.live, with: {count: 1000000, period: 0.01}}
  b: {uses: ticks.add, in: {number: a}}
"""


class Low(fs.Stage):
    """Keep the tracks below a height."""

    class Params(fs.StageParams):
        height: float = fs.Field(1.0, gt=0, description="highest position kept", unit="m")

    params: Params

    def process(self, tracks: Tracks) -> Tracks:
        return tracks.where(tracks.xyz[:, 2] < self.params.height)


def composed() -> fs.Graph:
    """graphs/glowballs.yaml without its bridge, and with a stage of this file at its end."""
    graph = fs.Graph("mine", room=ROOM)
    forecast = graph.port("track.forecast").delayed(1)
    camera = graph.add("camera", "room.source", each="cameras")
    color = graph.add(
        "color", "balls.color_blobs", each="cameras[kind=color]", frame=camera, forecast=forecast
    )
    infrared = graph.add(
        "infrared", "balls.ir_blobs", each="cameras[kind=infrared]", frame=camera, forecast=forecast
    )
    verify = graph.add("verify", "balls.verify_pairs", blobs=[color, infrared], forecast=forecast)
    found = graph.add("triangulate", "balls.triangulate", pairs=verify, forecast=forecast)
    fuse = graph.add("fuse", "balls.mean_shift", candidates=found, forecast=forecast, maximum_iterations=40)
    track = graph.add("track", "balls.kalman", positions=fuse)
    graph.add("low", Low, tracks=track.tracks, height=1.2)
    return graph


def test_a_graph_file_is_added_as_a_stage_with_the_arguments_of_its_interface(tmp_path: Path) -> None:
    graph = fs.Graph("two", room=ROOM)
    camera = graph.add("camera", "room.source", each="cameras")
    left = graph.add("left", GRAPH, cameras="cameras[name=cam0|cam1|cam2]", frames=camera, similarity=0.8)
    graph.add("right", Path(GRAPH), frames=camera, tracks_file="right.csv")
    graph.add("low", Low, tracks=left.tracks)
    plan = graph.plan()
    names = {stage.name: stage for stage in plan.stages}
    assert names["left/color/cam0"].params["similarity"] == 0.8
    assert names["right/save"].params["path"] == "right.csv"
    assert not {"left/camera/cam0", "left/color/cam5"} & names.keys()
    assert "left/track.tracks -> low.tracks" in {edge.name for edge in plan.edges}
    assert plan_of(graph.save(tmp_path / "two.yaml")) == plan_of(graph)
    with pytest.raises(fs.FollowspotError, match="no policies of its own"):
        graph.add("third", GRAPH, on_error="skip")
    with pytest.raises(fs.InputError, match="No such file"):
        graph.add("third", "gone.yaml")


def plan_of(graph: fs.Graph | Path) -> list[str]:
    """Instances and edges."""
    plan = graph.plan() if isinstance(graph, fs.Graph) else compile_graph(graph)
    return [*(stage.name for stage in plan.stages), *(edge.name for edge in plan.edges)]


@pytest.mark.parametrize("placement", [None, "camera"])
def test_a_subscription_misses_nothing_and_the_run_is_changed_on_the_way(
    tmp_path: Path, placement: str | None
) -> None:
    seen = []
    with fs.run(
        GRAPH,
        set={"fuse.uses": "balls.bundle", "color.similarity": 0.8},
        frames=60,
        placement=placement,
        ports=["track.tracks"],
        out=tmp_path,
    ) as run:
        for tracks in run["track.tracks"]:
            seen.append(tracks.header.seq)
            if len(seen) == 1:
                assert run.set("color.similarity", 0.85).stages[0].params == {"similarity": 0.85}
                assert run.swap("fuse", "balls.mean").stages[0].uses == "balls.mean"
    assert seen == list(range(60))
    report = run.report
    assert report.ok
    assert report.frames == 60
    assert {row["target"] for row in report.accuracy} == {"green", "red", "blue"}
    assert all(row["in_flight"] == 0 for row in report.ledger)
    assert (tmp_path / "tracks.csv").exists()
    assert "<table>" in report.ledger._repr_html_()
    assert "accuracy against ground truth" in repr(report)
    assert repr(run) == f"<run glowballs ({run.run[:8]}): ended>"


def test_two_ports_in_one_subscription_come_as_they_are_made(tmp_path: Path) -> None:
    with fs.run(GRAPH, frames=10, ports=["track.tracks,color"], out=tmp_path) as run:
        kinds = [type(message) for message in run["track.tracks,color"]]
    assert (kinds.count(Tracks), kinds.count(Blobs)) == (10, 30)


def test_a_port_that_nobody_reads_is_named_before_it_holds_up_the_run_for_ever(tmp_path: Path) -> None:
    with (
        fs.run(GRAPH, frames=200, ports=["track.tracks", "color"], out=tmp_path) as run,
        pytest.raises(fs.FollowspotError, match="no loop reads color, which holds up the run"),
    ):
        list(run["track.tracks"])


def test_waiting_for_a_run_that_waits_for_its_reader_says_so(tmp_path: Path) -> None:
    with fs.run(GRAPH, frames=200, ports=["track.tracks"], out=tmp_path) as run:
        with pytest.raises(fs.FollowspotError, match=r"no loop reads track.tracks, which holds up the run"):
            run.wait()
        with pytest.raises(fs.InputError, match=r"there is no port \"colour\"\n +did you mean \"color\""):
            run["colour"]
    assert run.report is run.report, "the truth is not read again"


def test_leaving_the_loop_ends_the_run_at_the_end_of_the_block(tmp_path: Path) -> None:
    (tmp_path / "endless.yaml").write_text(ENDLESS)
    with fs.run(tmp_path / "endless.yaml", plugin_files=[TICKS], ports=["b"], out=tmp_path / "out") as run:
        for number in run["b"]:
            if number.header.seq > 3:
                break
        assert run.status().fired >= 0
        assert not run.over()
    assert run.over()
    assert run.report.stopped
    assert run.report.ok
    with pytest.raises(fs.FollowspotError, match="the run has ended"):
        run.set("b.term", 2)


def test_an_exception_in_the_block_ends_the_run_and_is_the_one_that_is_raised(tmp_path: Path) -> None:
    (tmp_path / "endless.yaml").write_text(ENDLESS)
    run = fs.run(tmp_path / "endless.yaml", plugin_files=[TICKS], ports=["b"], out=tmp_path / "out")

    def interrupted() -> None:
        with run:
            next(run["b"])
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        interrupted()
    assert run.over()


@pytest.fixture
def interrupts() -> Iterator[None]:
    """SIGINT raises KeyboardInterrupt, as in a notebook; test processes may ignore it."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.mark.usefixtures("interrupts")
def test_ctrl_c_while_waiting_leaves_the_run_to_its_handle(tmp_path: Path) -> None:
    (tmp_path / "endless.yaml").write_text(ENDLESS)
    main = threading.main_thread().ident
    assert main is not None
    with fs.run(tmp_path / "endless.yaml", plugin_files=[TICKS], out=tmp_path / "out") as run:

        def interrupted() -> None:
            threading.Timer(0.3, signal.pthread_kill, [main, signal.SIGINT]).start()
            run.wait()

        with pytest.raises(KeyboardInterrupt):
            interrupted()
        assert not run.over()
        assert run.set("b.term", 5).stages[0].params == {"term": 5}
    assert run.report.stopped


def test_a_stage_that_fails_ends_the_loop_with_its_error(tmp_path: Path) -> None:
    class Fails(fs.Stage):
        """Raises at the third message."""

        def process(self, tracks: Tracks) -> Tracks:
            if tracks.header.seq == 3:
                raise ValueError("three is too many")
            return tracks

    graph = composed()
    graph.add("fails", Fails, tracks=graph.port("low"))
    run = fs.run(graph, frames=10, ports=["fails"], out=tmp_path)
    with pytest.raises(fs.RunFailed, match="three is too many"):
        list(run["fails"])
    with pytest.raises(fs.RunFailed, match="three is too many"):
        run.wait()
    assert not run.report.ok


def test_messages_come_to_an_event_loop_as_well(tmp_path: Path) -> None:
    async def count() -> int:
        with fs.run(GRAPH, frames=20, ports=["track.tracks"], out=tmp_path) as run:
            return len([tracks async for tracks in run["track.tracks"]])

    assert asyncio.run(count()) == 20


def test_a_composed_graph_is_saved_checked_drawn_and_run_with_a_class_of_this_process(tmp_path: Path) -> None:
    graph = composed()
    assert fs.check(graph, ports=["low"]) == []
    (warning,) = fs.check(graph)
    assert warning.text == 'no stage reads what stage "low" (here.low) gives'
    assert str(graph._repr_svg_()).startswith("<svg")
    with fs.run(graph, frames=15, ports=["low"], out=tmp_path) as run:
        heights = [tracks.xyz[:, 2].max(initial=0.0) for tracks in run["low"]]
    assert len(heights) == 15
    assert max(heights) < 1.2
    with pytest.raises(fs.FollowspotError, match="low: a class of this process cannot run beside"):
        fs.run(graph, placement="camera", out=tmp_path)


def test_a_run_that_has_ended_can_be_stopped(tmp_path: Path) -> None:
    with fs.run(GRAPH, out=tmp_path, frames=3) as run:
        assert run.wait().ok
        run.stop()


def test_a_class_of_this_process_takes_the_place_of_another_one(tmp_path: Path) -> None:
    class Empty(fs.Stage):
        """Keep no track."""

        def process(self, tracks: Tracks) -> Tracks:
            return Tracks.empty()

    graph = composed()
    with fs.run(graph, ports=["low"], out=tmp_path) as run:
        seen = iter(run["low"])
        next(seen)
        assert run.swap("low", Empty).stages[0].uses == "here.empty"
        assert any(tracks.is_empty for tracks in seen)


class Ready(fs.Stage):
    """Its setup takes until it may end."""

    asked, may_end = threading.Event(), threading.Event()
    closed = 0

    def setup(self) -> None:
        self.asked.set()
        assert self.may_end.wait(60)

    def process(self, tracks: Tracks) -> None: ...

    def close(self) -> None:
        type(self).closed += 1


def test_a_run_that_is_interrupted_while_it_starts_ends_by_itself(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    class Interrupted(threading.Event):
        """Ctrl-C comes while the script waits for the stages."""

        def wait(self, timeout: float | None = None) -> bool:
            if timeout == run_module._BEGIN:
                assert Ready.asked.wait(60)
                raise KeyboardInterrupt
            return super().wait(timeout)

    graph = composed()
    graph.add("ready", Ready, tracks=graph.port("track.tracks"))
    monkeypatch.setattr(run_module.threading, "Event", Interrupted)
    with pytest.raises(KeyboardInterrupt):
        fs.run(graph, out=tmp_path)
    monkeypatch.undo()
    (thread,) = [thread for thread in threading.enumerate() if thread.name == "run"]
    Ready.may_end.set()
    thread.join(60)
    assert not thread.is_alive()
    assert Ready.closed == 1


def test_two_runs_do_not_mix_their_files_in_one_folder(tmp_path: Path) -> None:
    (tmp_path / "endless.yaml").write_text(ENDLESS)
    graph, out = tmp_path / "endless.yaml", tmp_path / "out"
    with fs.run(graph, out=out, plugin_files=[TICKS]) as run:
        with pytest.raises(FollowspotError, match=r"(?s)another run writes to .*out.*choose another"):
            fs.run(graph, out=out, plugin_files=[TICKS]).wait()
        run.stop()
    with fs.run(graph, out=out, plugin_files=[TICKS]) as run:
        run.stop()
        assert run.wait().ok


@pytest.mark.parametrize("frames", [0, -1, 1.5])
def test_a_number_of_frames_that_is_none_is_refused_before_the_run(tmp_path: Path, frames: int) -> None:
    with pytest.raises(fs.InputError, match=r"(?s)frames is .*whole number from 1"):
        fs.run(GRAPH, out=tmp_path, frames=frames)


@pytest.mark.parametrize(
    ("option", "said"),
    [
        ({"edges": "rings"}, 'edges is .rings.\\n    did you mean "ring"'),
        ({"seed": -3}, r"seed is -3\n    give a whole number from 0 to 9223372036854775807"),
        ({"seed": 1 << 63}, "seed is 9223372036854775808"),
        ({"seed": "7"}, "seed is '7'"),
    ],
)
def test_an_option_that_cannot_be_is_refused_with_what_can(option: dict[str, Any], said: str) -> None:
    (mistake,) = fs.check(GRAPH, **option)
    assert re.match(said, str(mistake))


def test_a_single_name_needs_no_list(tmp_path: Path) -> None:
    with fs.run(GRAPH, out=tmp_path, frames=np.int64(3), ports="track.tracks") as run:
        assert len([*run["track.tracks"]]) == 3
    assert any("cam9" in mistake.text for mistake in fs.check(GRAPH, cameras="cam9"))
    assert fs.check(GRAPH, plugin_files=str(TICKS)) == []


@pytest.mark.parametrize("name", ["hall/left", "x" * 300, "\0"])
def test_a_composed_graph_quotes_itself_in_its_mistakes(name: str) -> None:
    (mistake,) = fs.check(fs.Graph(name))
    assert mistake.text.startswith("graph cannot be")
    graph = fs.Graph("mine")
    graph.add("camera", "cameras.video", path="balls.mp4", speed=3)
    mistakes = [mistake for mistake in fs.check(graph) if "speed" in mistake.text]
    assert str(mistakes[0]).startswith("<Graph mine>:5:")
    assert "speed: 3" in str(mistakes[0])


def test_numbers_of_numpy_are_parameters_and_another_value_is_named() -> None:
    graph = fs.Graph("mine", room=ROOM)
    graph.add("camera", "room.source", each="cameras")
    frame, each = graph.port("camera"), "cameras[kind=color]"
    color = graph.add("color", "balls.color_blobs", each=each, similarity=np.float64(0.9), frame=frame)
    assert "similarity: 0.9" in graph.to_yaml()
    with pytest.raises(FollowspotError, match=r'parameter "tolerance_3d" of stage "fuse" holds a set'):
        graph.add("fuse", "balls.mean_shift", candidates=color.out, tolerance_3d={1, 2})


def test_parameters_that_are_set_take_numbers_of_numpy_too(tmp_path: Path) -> None:
    given = {"similarity": np.float32(0.5), "minimum_brightness": np.int64(50)}
    settings = {f"color.{name}": value for name, value in given.items()}
    assert fs.check(GRAPH, set=settings) == []
    marks = {"track.marks": {"red": np.array([0.1, 0.2, 1.0])}}
    assert [mistake for mistake in fs.check(GRAPH, set=marks) if not mistake.warning] == []
    with pytest.raises(FollowspotError, match=r"color\.similarity cannot be 1j: it holds a complex"):
        fs.check(GRAPH, set={"color.similarity": 1j})
    (tmp_path / "endless.yaml").write_text(ENDLESS)
    with fs.run(tmp_path / "endless.yaml", out=tmp_path / "out", plugin_files=[TICKS]) as run:
        (stage,) = run.set("b.term", np.int64(2)).stages
        assert stage.params["term"] == 2
        with pytest.raises(fs.InputError, match="count is -1"):
            run.step(-1)


def test_a_name_that_every_stage_has_is_no_parameter_and_no_input_of_add() -> None:
    with pytest.raises(TypeError, match='no parameter can be named "tolerance": every stage has a key'):

        class Params(fs.StageParams):
            tolerance: float = fs.Field(0.1, description="what `add` would take for that of joins", unit="m")

    class Deep(fs.Stage):
        """An input with the name of an option."""

        def process(self, depth: Tracks) -> None: ...

    graph = fs.Graph("mine", room=ROOM)
    with pytest.raises(FollowspotError, match='"depth" is an option of `add`'):
        graph.add("deep", Deep, depth=graph.port("track.tracks"))  # type: ignore[arg-type]


def test_a_misspelt_input_is_told_with_the_right_one() -> None:
    graph = fs.Graph("mine", room=ROOM)
    balls = graph.add("balls", GRAPH)
    graph.add("again", "balls.kalman", positionz=balls.tracks)
    (mistake,) = [m for m in fs.check(graph) if "positionz" in m.text]
    assert "positions" in mistake.remedy


def test_a_type_that_was_defined_again_is_told_from_the_one_that_a_stage_takes() -> None:
    def cell() -> tuple[type[fs.Stage], type[fs.Stage]]:
        class Num(fs.Message):
            value: int

        class Give(fs.Stage):
            def process(self) -> fs.Source[Num]:
                yield fs.at(0, Num(1))

        class Take(fs.Stage):
            def process(self, num: Num) -> None:
                return None

        Give.process.__annotations__["return"] = fs.Source[Num]  # type: ignore[valid-type]
        Take.process.__annotations__["num"] = Num
        return Give, Take

    graph = fs.Graph("cells")
    give = graph.add("give", cell()[0])
    graph.add("take", cell()[1], num=give)
    (mistake,) = fs.check(graph)
    assert mistake.text == '"give" gives Num, but input "num" of stage "take" takes Num'
    assert mistake.remedy == (
        "these are two classes of one name, for Num was defined again: define the stages that use it again, "
        "too; in a notebook, run their cells"
    )


def test_a_saved_graph_is_the_same_as_the_composed_one(tmp_path: Path) -> None:
    graph = composed()
    del graph.stages["low"]
    assert plan_to_data(compile_graph(graph.save(tmp_path / "mine.yaml"))) == plan_to_data(graph.plan())


def test_mistakes_are_data_with_their_places() -> None:
    (mistake,) = fs.check(GRAPH, set={"fuse.steps": 3})
    assert 'no parameter "steps"' in mistake.text
    assert 'did you mean "maximum_iterations"' in mistake.remedy
    graph = composed()
    with pytest.raises(fs.FollowspotError, match="is there already"):
        graph.add("camera", "room.source")
    with pytest.raises(fs.FollowspotError, match="did you mean"):
        graph.add("other", "balls.mean_shif")


def test_another_script_holds_the_same_run(tmp_path: Path) -> None:
    (tmp_path / "endless.yaml").write_text(ENDLESS)
    with fs.run(tmp_path / "endless.yaml", plugin_files=[TICKS], out=tmp_path / "out") as run:
        with fs.connect(run.run) as other:
            assert other.plan().graph == "endless"
            assert "<td>running</td>" in other._repr_html_()
            assert repr(other).endswith(": running>")
            assert other.set("b.term", 5).stages[0].params == {"term": 5}
            assert [worker.phase for worker in other.status().workers] == ["running"]
        assert not run.over()
        with fs.connect(run.run) as other:
            other.stop()
        assert run.wait().stopped


def test_the_handle_is_safe_from_many_threads(tmp_path: Path) -> None:
    (tmp_path / "endless.yaml").write_text(ENDLESS)
    with fs.run(tmp_path / "endless.yaml", plugin_files=[TICKS], out=tmp_path / "out") as run:
        problems: list[BaseException] = []

        def meddle(number: int) -> None:
            try:
                for term in range(5):
                    run.set("b.term", 10 * number + term)
                    run.status()
            except BaseException as error:
                problems.append(error)

        threads = [threading.Thread(target=meddle, args=(number,)) for number in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
    assert problems == []


@pytest.mark.parametrize("ports", [(), ("track.tracks",)], ids=["later", "from the start"])
def test_a_subscription_to_messages_of_another_type_is_refused(
    tmp_path: Path, ports: tuple[str, ...]
) -> None:
    endless = {"camera.realtime": True, "camera.frames": 0}
    with fs.run(GRAPH, set=endless, ports=ports, out=tmp_path) as run:
        with pytest.raises(fs.FollowspotError, match=r"track\.tracks gives Tracks, not Blobs"):
            run.subscribe("track.tracks", Blobs)
        for tracks in run.subscribe("track.tracks", Tracks):
            assert tracks.xyz.shape[1] == 3
            break


TYPED = """
from typing import Any, assert_type

import followspot as fs
from followspot.tracking import Tracks

with fs.run("graph.yaml") as run:
    assert_type(run.subscribe("track.tracks", Tracks), fs.Subscription[Tracks])
    for tracks in run.subscribe("track.tracks", Tracks):
        assert_type(tracks, Tracks)
        print(tracks.xyz)
    for message in run["track.tracks"]:
        print(message.xyz)
    assert_type(next(fs.connect().subscribe("fuse", Tracks)), Tracks)
"""


@pytest.mark.thorough
def test_type_checkers_know_the_messages_of_a_subscription(tmp_path: Path) -> None:
    (tmp_path / "script.py").write_text(TYPED)
    command = [sys.executable, "-m", "mypy", "--strict", "--cache-dir", tmp_path / "cache", "script.py"]
    checked = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert checked.returncode == 0, checked.stdout


def test_editors_see_everything() -> None:
    assert {"run", "connect", "check", "Graph", "open_recording", "Stage", "at"} <= set(dir(fs))
    for name in dir(fs):
        assert name == "Source" or getattr(fs, name).__doc__, name


def test_a_script_knows_the_type_of_everything_but_tables_of_pandas() -> None:
    held = (fs.OwnRun, fs.ConnectedRun, fs.Subscription, fs.Report, fs.Table, fs.Recording, fs.Graph)
    methods = {f"{kind.__name__}.{name}": method for kind in held for name, method in vars(kind).items()}
    functions = {"run": fs.run, "connect": fs.connect, "check": fs.check, "open_recording": fs.open_recording}
    returned = {
        name: str(inspect.signature(function).return_annotation)
        for name, function in (methods | functions).items()
        if inspect.isfunction(function) and "._" not in name
    }
    assert {name for name, kind in returned.items() if kind == "Any"} == {"Table.to_pandas"}


def test_an_unfinished_graph_and_a_message_show_themselves() -> None:
    unfinished = fs.Graph("mine")
    unfinished.add("fuse", "balls.mean_shift")
    assert unfinished._repr_svg_() is None
    assert repr(unfinished) == "<Graph mine: fuse>"
    shown = fs.at(7, Blobs.empty())._repr_html_()
    assert "<caption>Blobs -1 of no source at 7 ns</caption>" in shown
    assert "<td>xy</td><td>0 x 2</td><td>px</td>" in shown
