"""`run` and `connect`: a script starts a graph, changes it, waits for it and ends it, as another may, too."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from tests.core.library.scripts import GRAPH, TICKS, composed, endless

import followspot as fs
import followspot.library.own_run as run_module
from followspot.errors import FollowspotError
from followspot.tracking import Candidates, Forecast, Positions, Tracks


def test_a_single_name_needs_no_list(tmp_path: Path) -> None:
    with fs.run(GRAPH, out=tmp_path, frames=np.int64(3), ports="track.tracks") as run:
        assert len([*run["track.tracks"]]) == 3
    assert any("cam9" in mistake.text for mistake in fs.check(GRAPH, cameras="cam9"))
    assert fs.check(GRAPH, plugin_files=str(TICKS)) == []


@pytest.mark.parametrize("frames", [0, -1, 1.5])
def test_a_number_of_frames_that_is_none_is_refused_before_the_run(tmp_path: Path, frames: int) -> None:
    with pytest.raises(fs.InputError, match=r"(?s)frames is .*whole number from 1"):
        fs.run(GRAPH, out=tmp_path, frames=frames)


def test_two_runs_do_not_mix_their_files_in_one_folder(tmp_path: Path) -> None:
    with endless(tmp_path) as run:
        with pytest.raises(FollowspotError, match=r"(?s)another run writes to .*out.*choose another"):
            endless(tmp_path).wait()
        run.stop()
    with endless(tmp_path) as run:
        run.stop()
        assert run.wait().ok


def test_parameters_that_are_set_take_numbers_of_numpy_too(tmp_path: Path) -> None:
    given = {"similarity": np.float32(0.5), "minimum_brightness": np.int64(50)}
    settings = {f"color.{name}": value for name, value in given.items()}
    assert fs.check(GRAPH, set=settings) == []
    marks = {"track.marks": {"red": np.array([0.1, 0.2, 1.0])}}
    assert [mistake for mistake in fs.check(GRAPH, set=marks) if not mistake.warning] == []
    with pytest.raises(FollowspotError, match=r"color\.similarity cannot be 1j: it holds a complex"):
        fs.check(GRAPH, set={"color.similarity": 1j})
    with endless(tmp_path) as run:
        (stage,) = run.set("b.term", np.int64(2)).stages
        assert stage.params["term"] == 2
        with pytest.raises(fs.InputError, match="count is -1"):
            run.step(-1)


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


class Median(fs.Stage):
    """The median of each target's candidates."""

    def process(self, candidates: Candidates, forecast: fs.Latest[Forecast] = None) -> Positions:
        target = np.flatnonzero(candidates.targets.any(axis=0))
        used = candidates.targets.T[target]
        xyz = np.array([np.median(candidates.xyz[row], axis=0) for row in used]).reshape(-1, 3)
        return Positions.fused(candidates, target, used, xyz)


def test_a_class_of_this_process_takes_the_place_of_a_stage_of_a_file_from_the_beginning(
    tmp_path: Path,
) -> None:
    mine = {"fuse.uses": Median}
    assert fs.check(GRAPH, set=mine) == []
    with fs.run(GRAPH, set=mine, frames=40, out=tmp_path) as run:
        assert "here.median" in {stage.uses for stage in run.plan().stages}
        assert min(row["coverage"] for row in run.wait().accuracy) > 0.9
    with pytest.raises(FollowspotError, match="put it into a file and name that in plugin_files"):
        fs.run(GRAPH, set=mine, out=tmp_path, placement="camera")
    with pytest.raises(FollowspotError, match="Path has no method `process`"):
        fs.check(GRAPH, set={"fuse.uses": Path})


def test_the_handle_is_safe_from_many_threads(tmp_path: Path) -> None:
    with endless(tmp_path) as run:
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


def test_another_script_holds_the_same_run(tmp_path: Path) -> None:
    with endless(tmp_path) as run:
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


def test_a_run_that_has_ended_can_be_stopped(tmp_path: Path) -> None:
    with fs.run(GRAPH, out=tmp_path, frames=3) as run:
        assert run.wait().ok
        run.stop()


def test_an_exception_in_the_block_ends_the_run_and_is_the_one_that_is_raised(tmp_path: Path) -> None:
    run = endless(tmp_path, ports=["b"])

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
    main = threading.main_thread().ident
    assert main is not None
    with endless(tmp_path) as run:

        def interrupted() -> None:
            threading.Timer(0.3, signal.pthread_kill, [main, signal.SIGINT]).start()
            run.wait()

        with pytest.raises(KeyboardInterrupt):
            interrupted()
        assert not run.over()
        assert run.set("b.term", 5).stages[0].params == {"term": 5}
    assert run.report.stopped


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
