"""The walks in docs/architecture.md are those of real calls: they are traced, file by file.

A file is on a walk if one of its functions is handed what the walk follows, in whatever form, or returns it.
"""

from __future__ import annotations

import re
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from types import FrameType
from typing import Any

import pytest

import followspot as fs
from followspot.cli.main import main
from followspot.control.swap import ChangeOrder
from followspot.graph.compile import compile_graph
from followspot.host.worker_thread import WorkerThread
from followspot.operator.launch import local_run
from followspot.operator.run_requests import ChangeStages
from followspot.tracking import Frame
from followspot.worker.wiring import RunOptions

CORE = Path(fs.__file__).parent
DOC = Path(__file__).parents[2] / "docs" / "architecture.md"
STAGES = Path(__file__).parents[1] / "stages"
PICTURES = """
graph: pictures
stages:
  camera: {uses: pictures.camera}
  gray:   {uses: pictures.gray, in: {frame: camera}}
  keep:   {uses: pictures.keep, in: {frame: gray}}
"""
ENDLESS = """
graph: walked
stages:
  a: {uses: ticks.live, with: {count: 1000000, period: 0.02}}
  b: {uses: ticks.tally, in: {number: a}}
"""
WORD = "b.step=7"


def documented(title: str) -> list[str]:
    """The files of the numbered list in a section, in order."""
    section = DOC.read_text().partition(f"## {title}\n")[2].partition("\n## ")[0]
    steps = re.findall(r"^\d+\. `([\w/]+\.py)`", section, re.MULTILINE)
    assert len(steps) == len(re.findall(r"^\d+\. ", section, re.MULTILINE)), "a step without its file"
    return steps


@contextmanager
def profiled(profile: Callable[[FrameType, str, Any], None]) -> Iterator[None]:
    """Call a profile function for this thread, and for those that start now."""
    threading.setprofile(profile)
    sys.setprofile(profile)
    try:
        yield
    finally:
        threading.setprofile(None)
        sys.setprofile(None)


@contextmanager
def traced(carries: Callable[[Any], bool]) -> Iterator[list[str]]:
    """Files of the core in the order in which they get what is followed; in all threads that start now."""
    files: list[str] = []

    def note(file: str) -> None:
        path = Path(file)
        if path.is_relative_to(CORE) and (name := str(path.relative_to(CORE))) not in files:
            files.append(name)

    def profile(frame: FrameType, event: str, returned: Any) -> None:
        code = frame.f_code
        if event not in ("call", "return") or not code.co_filename.startswith(f"{CORE}/"):
            return
        named = code.co_varnames[: code.co_argcount + code.co_kwonlyargcount] if event == "call" else ()
        handed = [frame.f_locals[name] for name in named if name in frame.f_locals]
        if any(map(carries, handed)) or (event == "return" and carries(returned)):
            if not files and frame.f_back is not None:
                note(frame.f_back.f_code.co_filename)
            note(code.co_filename)

    with profiled(profile):
        yield files


def is_the_change(value: Any) -> bool:
    """Whether it is the words of the change, a request or an order for it, or either on the wire."""
    if isinstance(value, ChangeStages | ChangeOrder):
        return True
    if isinstance(value, dict):
        return value.get("verb") in ("change_stages", "change_order")
    if isinstance(value, bytes | bytearray):
        return b"change_stages" in value or b"change_order" in value
    return isinstance(value, list | tuple) and (list(value) == [WORD] or any(map(is_the_change, value)))


def test_the_walk_of_a_swap_is_the_documented_one_and_has_at_most_ten_files(tmp_path: Path) -> None:
    graph = tmp_path / "walked.yaml"
    graph.write_text(ENDLESS)
    with (
        traced(is_the_change) as files,
        fs.run(graph, plugin_files=[STAGES / "ticks.py"], out=tmp_path / "out") as run,
    ):
        assert main(["swap", "--run", run.run, WORD]) == 0
    assert files == documented("The life of a swap")
    assert len(files) <= 10


def on_the_stack(frame: FrameType | None) -> list[str]:
    """The files of the core whose functions are at work in a thread, each where it is first entered."""
    files: list[str] = []
    while frame is not None:
        path = Path(frame.f_code.co_filename)
        if path.is_relative_to(CORE):
            files.append(str(path.relative_to(CORE)))
        frame = frame.f_back
    return list(dict.fromkeys(reversed(files)))


@contextmanager
def start_traced() -> Iterator[list[str]]:
    """The files that are at work as a worker is started, then those in the worker as a stage processes."""
    files: list[str] = []
    seen: set[object] = set()

    def profile(frame: FrameType, event: str, _: Any) -> None:
        code = frame.f_code
        of_a_stage = code.co_name == "process" and code.co_filename == str(STAGES / "pictures.py")
        if event == "call" and code not in seen and (code is WorkerThread.__init__.__code__ or of_a_stage):
            seen.add(code)
            files.extend(file for file in on_the_stack(frame) if file not in files)

    with profiled(profile):
        yield files


def test_the_walk_from_the_command_to_a_stage_is_the_documented_one(tmp_path: Path) -> None:
    graph = tmp_path / "pictures.yaml"
    graph.write_text(PICTURES)
    words = [str(graph), "--plugin", str(STAGES / "pictures.py"), "--out", str(tmp_path / "out"), "-q"]
    with start_traced() as files:
        assert main(["run", *words]) == 0
    assert files == documented("The start of a run")


def holds_a_frame(value: Any) -> bool:
    return isinstance(value, Frame) or (
        isinstance(value, list | tuple) and any(holds_a_frame(item) for item in value[:8])
    )


@pytest.mark.parametrize("placement", [None, "stage"])
def test_the_walk_of_a_frame_is_the_documented_one(tmp_path: Path, placement: str | None) -> None:
    """In one worker, and over rings; the workers are threads, in which the calls can be traced."""
    (tmp_path / "pictures.yaml").write_text(PICTURES)
    plan = compile_graph(
        tmp_path / "pictures.yaml", placement=placement, plugin_files=[STAGES / "pictures.py"]
    )
    workers = [worker.name for worker in plan.workers]
    with traced(holds_a_frame) as files:
        report = local_run(plan, RunOptions(tmp_path), in_process=workers).execute()
    assert report.ok, report.errors
    steps = documented("The life of a Frame")
    assert set(files) == {step for step in steps if placement or not step.startswith("transport/")}
    assert files == sorted(files, key=steps.index)
