"""What a disk refuses is told in a line that names the file, whichever command meets it."""

from __future__ import annotations

import os
import shlex
import subprocess
from pathlib import Path

import pytest
from tests.commands import COMMAND, command
from tests.full_disk import full_disk

from followspot.cli.main import main

GRAPH = Path(__file__).parents[3] / "graphs/glowballs.yaml"


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (("graph", GRAPH, "--svg", "/proc/none/plan.svg"), "/proc/none/plan.svg"),
        (("new", "plugin", "mine", "--dir", "/proc"), "/proc/followspot-mine"),
    ],
)
def test_what_cannot_be_written_is_named_without_a_traceback(words: tuple[object, ...], told: str) -> None:
    done = command(*words)
    assert done.returncode == 1
    assert done.stderr.startswith(f"followspot: {told}")
    assert "Traceback" not in done.stderr


class Disk:
    """Commands on a disk that takes no more than so many bytes of a file."""

    def __init__(self, capsys: pytest.CaptureFixture[str]) -> None:
        self._capsys = capsys

    def full(self, limit: int, *words: object) -> tuple[int, str]:
        """A command's exit code and what it says of errors."""
        self._capsys.readouterr()
        with full_disk(limit):
            code = main(list(map(str, words)))
        return code, self._capsys.readouterr().err


@pytest.fixture
def disk(capsys: pytest.CaptureFixture[str]) -> Disk:
    return Disk(capsys)


def test_a_full_disk_leaves_no_half_copy_of_a_graph(tmp_path: Path, disk: Disk) -> None:
    code, errors = disk.full(10, "graphs", "glowballs", "--to", tmp_path)
    assert code == 2
    assert f"{tmp_path}/glowballs.yaml cannot be written: File too large" in errors
    assert not (tmp_path / "glowballs.yaml").exists()
    assert disk.full(1 << 20, "graphs", "glowballs", "--to", tmp_path)[0] == 0


def test_a_full_disk_leaves_a_package_as_it_was(tmp_path: Path, disk: Disk) -> None:
    assert disk.full(10, "new", "plugin", "other", "--dir", tmp_path)[1] == (
        f"followspot: {tmp_path}/followspot-other/pyproject.toml cannot be written: File too large\n"
    )
    assert command("new", "plugin", "studio", "--dir", tmp_path).returncode == 0
    project = tmp_path / "followspot-studio/pyproject.toml"
    before = project.read_bytes()
    for limit in (10, len(before)):  # the second takes the stage
        errors = disk.full(limit, "new", "stage", f"low{limit}", "--dir", project.parent)[1]
        assert "cannot be written: File too large" in errors
        assert project.read_bytes() == before


def test_a_table_that_a_full_disk_cuts_short_is_named(tmp_path: Path, disk: Disk) -> None:
    recording = tmp_path / "show.mcap"
    words = ("--record-ports", "track.tracks", "--record", recording, "--out", tmp_path / "out")
    command("run", GRAPH, "--frames", 3, *words, check=True)
    for form in ("csv", "jsonl", "parquet"):
        code, errors = disk.full(100, "export", recording, "--to", form, tmp_path / form)
        assert code == 1
        assert f"{tmp_path}/{form}/track.tracks.{form} cannot be written: " in errors


@pytest.mark.parametrize(
    ("words", "file"),
    [(("graph", GRAPH, "--svg"), "plan.svg"), (("schema", "room", "-o"), "room.json")],
)
def test_a_file_that_a_full_disk_cuts_short_is_named(
    tmp_path: Path, disk: Disk, words: tuple[object, ...], file: str
) -> None:
    told = f"followspot: {tmp_path / file} cannot be written: File too large\n"
    assert disk.full(10, *words, tmp_path / file) == (1, told)


@pytest.mark.parametrize("more", [(), ("--templates",)])
def test_a_simulated_video_that_a_full_disk_cuts_short_is_named(
    tmp_path: Path, disk: Disk, more: tuple[str, ...]
) -> None:
    words = ("simulate", "--room", GRAPH.parent / "rooms/simulated.yaml", "--frames", 4, *more)
    code, errors = disk.full(10_000, *words, "--out", tmp_path)
    assert code == 1
    assert ".mkv is cut short\n    free space on the disk" in errors


def test_a_full_disk_behind_the_output_is_told() -> None:
    with Path("/dev/full").open("w") as full:
        done = subprocess.run([*COMMAND, "graphs"], stdout=full, stderr=subprocess.PIPE, text=True)
    assert done.returncode == 1
    assert "No space left on device" in done.stderr
    assert "Traceback" not in done.stderr


@pytest.mark.parametrize(
    "closed",
    ["<&- >&- 2>&-", *(pytest.param(one, marks=pytest.mark.thorough) for one in ("<&-", ">&-", "2>&-"))],
)
def test_a_stream_that_is_closed_costs_a_run_nothing(tmp_path: Path, closed: str) -> None:
    words = shlex.join([*COMMAND, "run", str(GRAPH), "--frames", "2", "--out", str(tmp_path)])
    assert subprocess.run(["sh", "-c", f"{words} {closed}"], capture_output=True).returncode == 0
    lines = (tmp_path / "tracks.csv").read_text().splitlines()
    assert {line.partition(",")[0] for line in lines} == {"frame", "0", "1"}


def test_a_reader_that_has_gone_ends_a_command_quietly() -> None:
    read, write = os.pipe()
    os.close(read)
    with os.fdopen(write, "w") as gone:
        done = subprocess.run([*COMMAND, "plugins"], stdout=gone, stderr=subprocess.PIPE, text=True)
    assert done.returncode in (1, 120), "120 is Python's own"
    assert "Traceback" not in done.stderr


def test_what_a_terminal_cannot_show_is_escaped_and_does_not_end_the_command(tmp_path: Path) -> None:
    """A terminal of another encoding, and a folder whose name is no UTF-8."""
    words = [*COMMAND, "run", str(GRAPH), "--frames", "1", "-q", "--out"]
    for encoding, out in (("ascii", "out"), ("utf-8", os.fsdecode(b"caf\xe9"))):
        environment = os.environ | {"PYTHONIOENCODING": encoding}
        done = subprocess.run([*words, out], capture_output=True, cwd=tmp_path, env=environment)
        assert done.returncode == 0, done.stderr
        assert f"outputs: {ascii(out)[1:-1]}".encode() in done.stdout


def test_a_run_says_which_outputs_of_an_earlier_one_it_replaces(tmp_path: Path) -> None:
    words = ("run", GRAPH, "--frames", "1", "-q", "--out", tmp_path)
    line = f"warning: an earlier run left tracks.csv in {tmp_path}; this one replaces it\n"
    assert [line in command(*words).stderr for _ in range(2)] == [False, True]
