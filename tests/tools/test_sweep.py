"""`followspot sweep`: what spans the grid, what is run, what is kept, and what is told."""

from __future__ import annotations

import csv
import json
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest
from tests.full_disk import full_disk

from followspot.cli.main import main
from followspot.errors import FollowspotError, InputError
from followspot.graph.compile import compile_graph
from followspot.room import StageUse
from followspot_sweep.axes import MAX_POINTS, Axis, points, read_axes
from followspot_sweep.figures import figures_of
from followspot_sweep.fingerprint import fingerprint_of
from followspot_sweep.no_effect import axes_without_effect
from followspot_sweep.plot import PLOT, draw
from followspot_sweep.table import best, rows, text, write
from followspot_sweep.trial import SUMMARY, Result, Task, folder_name, kept, run

GRAPH = str(Path(__file__).parents[2] / "graphs/glowballs.yaml")


def values(option: str) -> tuple[str, ...]:
    return next(iter(read_axes([option, "other.key=1,2"]))).values


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("1,2,3", ("1", "2", "3")),
        ("0.7:0.9:0.05", ("0.70", "0.75", "0.80", "0.85", "0.90")),
        ("3:1:-1", ("3", "2", "1")),
        ("2:2:1", ("2",)),
        ("1:2:0.4", ("1.0", "1.4", "1.8")),
        ("balls.mean,balls.mean_shift", ("balls.mean", "balls.mean_shift")),
        ("[1, 2],[3, 4]", ("[1, 2]", "[3, 4]")),
        ("a,a", ("a",)),
        ("tls/host:1:x", ("tls/host:1:x",)),
    ],
)
def test_values_are_listed_or_counted_from_start_to_stop(text: str, expected: tuple[str, ...]) -> None:
    assert values(f"fuse.bandwidth_scale={text}") == expected


def test_the_grid_has_every_combination() -> None:
    grid = points(read_axes(["a.x=1,2", "b.y=3", "c.z=4:6:1"]))
    assert len(grid) == len(set(grid)) == 6
    assert grid[1] == (("a.x", "1"), ("b.y", "3"), ("c.z", "5"))
    assert len({folder_name(point) for point in grid}) == 6


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ([], "nothing to sweep"),
        (["a.x=1"], "nothing to sweep"),
        (["a.x"], "A,B,C or STAGE.KEY=START:STOP:STEP"),
        (["a.x=1,2", "a.x=3,4"], "given twice"),
        (["a.x=1:2:0"], "is no range"),
        (["a.x=1:2:-1"], "is no range"),
        (["a.x=0:1e9:1"], "is no range"),
        (["a.x=0:0:0"], "is no range"),
        (["a.x=1:2"], "is no range"),
        (["a.x=nan:2:1"], "is no range"),
        (["a.x=1:inf:1"], "is no range"),
        (["a.x=1:1e9999999:1"], "is no range"),
        (["a.x=1:2:1e-9999999"], "is no range"),
        (["a.x=1:1000:1", "b.x=1:1000:1"], f"at most {MAX_POINTS}"),
    ],
)
def test_a_grid_that_cannot_be_is_refused(options: list[str], said: str) -> None:
    with pytest.raises(InputError, match=said):
        read_axes(options)


def test_names_of_folders_stay_inside() -> None:
    name = folder_name((("save.path", "../../etc/passwd"),))
    assert "/" not in name


def test_figures_are_means_sums_and_the_slowest() -> None:
    one = {"frames": 10, "rmse_mm": 2.0, "identity_switches": 1, "recovery_worst": 3, "recovery_frames": [3]}
    two = {"frames": 10, "rmse_mm": 4.0, "identity_switches": 2, "recovery_worst": 9, "false_share": None}
    gone = {"frames": 0, "rmse_mm": None, "identity_switches": 5}
    found = figures_of({"frames": 10, "targets": {"a": one, "b": two, "c": gone}})
    assert found == {"frames": 10.0, "rmse_mm": 3.0, "identity_switches": 3, "recovery_worst": 9}
    persons = {"all": {"coverage": 0.5, "torso": {"median_deg": 7}, "ids": [1], "x": None}, "1": {}}
    found = figures_of({"frames": 3, "persons": persons})
    assert found == {"frames": 3.0, "coverage": 0.5, "torso_median_deg": 7.0}


def result(x: str, rmse: float | None, error: str = "") -> Result:
    task = Task("studio", (("fuse.x", x), ("fuse.uses", "mean")), ("run",), Path(), "")
    return Result(task, {} if rmse is None else {"rmse_mm": rmse, "coverage": 1.0}, error)


RESULTS = [result("1", 3.0), result("2", 2.0), result("4", None, "it broke")]
AXES = (Axis("fuse.x", ("1", "2", "4")), Axis("fuse.uses", ("mean",)))


def test_the_table_marks_the_best_and_what_failed(tmp_path: Path) -> None:
    found = rows(RESULTS)
    assert best(found, "rmse_mm") is found[1]
    lines = text(found, AXES, "rmse_mm").splitlines()
    assert "fuse.uses" not in lines[0]
    assert lines[2].endswith("*")
    assert lines[3].endswith("failed")
    assert "sweep.csv" in write(found, tmp_path)
    with (tmp_path / "sweep.csv").open(newline="") as file:
        read = list(csv.DictReader(file))
    assert [row["rmse_mm"] for row in read] == ["3.0", "2.0", ""]
    assert read[2]["error"] == "it broke"


def test_the_parquet_file_has_numbers(tmp_path: Path) -> None:
    parquet = pytest.importorskip("pyarrow.parquet")
    write(rows(RESULTS), tmp_path)
    table = parquet.read_table(tmp_path / "sweep.parquet")
    assert table["fuse.x"].to_pylist() == [1.0, 2.0, 4.0]
    assert table["rmse_mm"].to_pylist() == [3.0, 2.0, None]


def test_each_parameter_has_its_panel(tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    assert "sweep.svg" in draw(rows(RESULTS), AXES, "rmse_mm", tmp_path)
    assert "fuse.x" in (tmp_path / PLOT).read_text()
    assert draw(rows(RESULTS), AXES, "height", tmp_path) == 'no plot: no run has a figure "height"'


def test_a_result_is_kept_for_the_same_graph_only(tmp_path: Path) -> None:
    task = Task("studio", (("a.x", "1"),), ("run", "g.yaml"), tmp_path, "before")
    summary = {"frames": 5, "targets": {}}
    (tmp_path / SUMMARY).write_text(
        json.dumps({"command": ["run", "g.yaml"], "fingerprint": "before", "summary": summary})
    )
    found = kept(task)
    assert found is not None
    assert found.figures == {"frames": 5.0}
    assert kept(Task("studio", task.point, task.command, tmp_path, "after")) is None
    for torn in ("", "{", "[]", '{"command": 1}'):
        (tmp_path / SUMMARY).write_text(torn)
        assert kept(task) is None


def test_a_run_that_fails_says_why_and_is_not_kept(tmp_path: Path) -> None:
    task = Task("studio", (("a.x", "1"),), ("run", str(tmp_path / "none.yaml")), tmp_path, "")
    assert "cannot read" in run(task, lambda process: None).error
    assert kept(task) is None


@pytest.mark.parametrize(
    ("written", "error", "found"),
    [
        ({"1": "a", "2": "a"}, "", ["a.x"]),
        ({"1": "a", "2": "b"}, "", []),
        ({"1": "a", "2": "a"}, "it was stopped", []),
        ({"1": None, "2": None}, "", []),
    ],
)
def test_a_parameter_whose_values_give_the_same_files_changes_nothing(
    tmp_path: Path, written: dict[str, str | None], error: str, found: list[str]
) -> None:
    """The other axis changes the files; a run's summary tells its times, and does not count."""
    axes = (Axis("a.x", ("1", "2")), Axis("b.y", ("3", "4")))
    results = []
    for point in points(axes):
        values = dict(point)
        task = Task("studio", point, (), tmp_path / folder_name(point), "")
        task.folder.mkdir()
        (task.folder / SUMMARY).write_text(repr(point))
        if (text := written[values["a.x"]]) is not None:
            (task.folder / "tracks.csv").write_text(text + values["b.y"])
        results.append(Result(task, {}, error))
    assert axes_without_effect(results, axes) == found


def test_a_sweep_runs_every_point_once_and_goes_on_where_it_was(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ["sweep", GRAPH, "--set", "fuse.uses=balls.mean_shift,balls.mean", "--frames", "3"]
    words += ["-o", str(tmp_path), "--json"]
    assert main([*words, "--jobs", "2"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert [row["fuse.uses"] for row in told["rows"]] == ["balls.mean_shift", "balls.mean"]
    assert all(row["rmse_mm"] > 0 for row in told["rows"])
    assert told["best"] in told["rows"]
    assert told["without_effect"] == []
    made = {path: path.stat().st_mtime_ns for path in tmp_path.glob(f"*/*/{SUMMARY}")}
    assert len(made) == 2
    assert main(words) == 0
    captured = capsys.readouterr()
    assert "2 of 2 are done already" in captured.err
    assert json.loads(captured.out) == told
    assert {path: path.stat().st_mtime_ns for path in made} == made


def test_results_of_another_plugin_file_or_video_are_not_kept(tmp_path: Path) -> None:
    """The plan holds the names of both, and the result depends on what is in them."""
    (tmp_path / "lower.py").write_text(
        "from followspot import Stage\n"
        "from followspot.tracking import Tracks\n"
        "class Low(Stage):\n"
        "    def process(self, tracks: Tracks) -> Tracks:\n"
        "        return tracks\n"
    )
    changes = "stages: {low: {uses: lower.low, in: {tracks: track}}}"
    (tmp_path / "graph.yaml").write_text(f"extends: {GRAPH}\n{changes}\n")
    (tmp_path / "clips").mkdir()
    (tmp_path / "clips/cam0.mkv").write_bytes(b"a video")

    def fingerprint() -> str:
        plan = compile_graph(tmp_path / "graph.yaml", plugin_files=[str(tmp_path / "lower.py")])
        source = StageUse("video.file", {"path": "clips/cam0.mkv"}, str(tmp_path))
        camera = replace(plan.room.cameras["cam0"], source=source)
        return fingerprint_of([replace(plan, room=replace(plan.room, cameras={"cam0": camera}))])

    found = [fingerprint(), fingerprint()]
    for changed in ("lower.py", "clips/cam0.mkv"):
        with (tmp_path / changed).open("ab") as file:
            file.write(b"# more")
        found.append(fingerprint())
    assert found[0] == found[1]
    assert len(set(found)) == 3


SWEEP = """
import os, subprocess, sys, time
words = [sys.executable, "-m", "followspot_sweep.child_process", str(os.getpid())]
run = subprocess.Popen([*words, "agent", "--name", "bound", "--listen", "tcp/127.0.0.1:0"])
print(run.pid, flush=True)
time.sleep(60)
"""


def test_a_sweep_that_is_killed_leaves_no_run_behind() -> None:
    pipe = subprocess.PIPE
    with subprocess.Popen([sys.executable, "-c", SWEEP], stdout=pipe, stderr=pipe, text=True) as sweep:
        assert sweep.stdout is not None
        assert sweep.stderr is not None
        run = Path(f"/proc/{int(sweep.stdout.readline())}/stat")
        assert "listens" in sweep.stderr.readline()
        sweep.kill()
        assert sweep.stderr.read() == ""  # the run held it open, too
    assert not run.exists() or run.read_text().rpartition(") ")[2].startswith("Z")
    orphan = [sys.executable, "-m", "followspot_sweep.child_process", "1", "--version"]
    assert subprocess.run(orphan, check=False).returncode == 1


def test_every_wrong_value_is_named_before_anything_runs(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    options = ["--set", "fuse.uses=balls.mean,balls.meen", "--set", "color.similarity=0.5,high"]
    assert main(["sweep", GRAPH, *options, "-o", str(tmp_path / "out")]) == 2
    told = capsys.readouterr().err
    assert 'did you mean "balls.mean"' in told
    assert "'high'" in told
    assert not (tmp_path / "out").exists()


def test_a_table_that_a_full_disk_cuts_short_is_named(tmp_path: Path) -> None:
    with full_disk(10), pytest.raises(FollowspotError, match=r"sweep\.csv cannot be written: File too large"):
        write(rows(RESULTS), tmp_path)
