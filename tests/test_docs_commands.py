"""Every command that the documents show is run: here, or by the test that is named here."""

from __future__ import annotations

import json
import re
import shlex
from pathlib import Path

import pytest

from followspot.cli.main import main

ROOT = Path(__file__).parent.parent
PAGES = {page.name: page.read_text() for page in (ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md")))}
FENCED = re.compile(r"^```(?P<language>\S*)\n(?P<text>.*?)^```$", re.DOTALL | re.MULTILINE)
FILE = re.compile(r"# (?P<name>\w+\.yaml)\n")
"""The first line of a file that a page shows whole."""
PROGRAM = re.compile(r"followspot|make|python|pip|pytest|cp|cd|\. ")

ELSEWHERE = {
    r"(make|\. )": ".ci/run",
    r"(cd|pip|pytest)": "tests/test_tutorial.py",
    r"followspot run walk.yaml": "tests/test_sources.py",
    r"followspot (new|plugins studio|run graph.yaml)": "tests/test_tutorial.py",
    r"python tools/bench/balls/bounces.py": "tests/tools/bench/test_bounces.py",
    r"python tools/paper_tables.py": "tests/tools/test_paper_tables.py",
    r"python tools/bench/persons/busy_machine.py": "tests/tools/bench/test_persons_busy_machine.py",
    r"python tools/bench/persons/speed.py": "tests/tools/bench/test_persons_speed.py",
    r"python tools/bench_strangers.py": "tests/tools/bench/test_strangers.py",
    r"python tools/learn_weights.py": "tests/tools/test_learn_weights.py",
    r"python tools/convert_movenet.py": "tests/tools/test_convert_movenet.py",
    r"python tools/try_whole_bodies.py": "tests/tools/test_try_whole_bodies.py",
    r"python3 -m venv": ".ci/run",
    r"python tools/speed_page.py": "tests/tools/test_speed_page.py",
    r"python tools/bench/runtime/live_latency.py": "tests/tools/bench/test_live_latency.py",
    r"python tools/bench": "tests/tools/bench/test_benchmarks.py",
    r"followspot .*--dashboard|followspot dashboard": "tests/integration/test_dashboard.py",
    r"followspot (runs|top|hz|echo|logs)": "tests/tools/watch",
    r"followspot (swap|set)": "tests/integration/test_swap.py",
    r"followspot mark|followspot run .*--keep": "tests/tools/flight/test_kept_runs.py",
    r"followspot save": "tests/tools/page/test_save.py",
    r"followspot move": "tests/integration/test_move.py",
    r"followspot (pause|step|resume)": "tests/integration/test_pause.py",
    r"followspot (agent|router)|followspot run .*--(connect|listen)": "tests/integration/test_agents.py",
    r"followspot run .*--placement": "tests/integration/test_placement.py",
    r"followspot calibrate": "tests/integration/test_calibration_chain.py",
    r"followspot room (import|export)": "tests/tools/test_calibration_formats.py",
    r"followspot room rectify": "tests/tools/test_room_rectify.py",
    r"followspot room new|followspot calibrate targets .*--pick": "tests/tools/test_own_ball.py",
    r"followspot room guess": "tests/tools/test_room_guess.py",
    r"followspot compare": "tests/tools/test_compare.py",
    r"followspot sweep": "tests/tools/test_sweep.py",
    r"python tools/render_crops.py": "tests/tools/test_render_crops.py",
    r"followspot train headings": "tests/tools/train/test_train_headings.py",
    r"followspot train whole": "tests/tools/train/test_train_whole.py",
    r"followspot train": "tests/tools/train/test_train.py",
    r"followspot run .*--room (?!graphs/)": "tests/integration/test_recordings.py",
    r"followspot score": "tests/tools/test_persons_commands.py",
    r"followspot cameras": "tests/plugins/cameras/test_genicam_listing.py",
    r"followspot doctor --(room studio|connect)": "tests/tools/test_doctor.py",
    r"python -c .from viva_genicam": "tests/plugins/cameras/test_genicam_viva.py",
    r"cp": "tests/tools/test_experiment_pages.py",
}
"""Beginnings of commands that need devices, other hosts, a browser, recordings, a run that goes on or many
minutes, and the test that runs them with what it has made for them."""
FOLLOWED = "tutorial.md"
"""Whose every line tests/test_tutorial.py follows."""


def shown(page: str) -> list[str]:
    """The commands of a page, with continued lines joined and without what is said of them."""
    found = [block["text"] for block in FENCED.finditer(PAGES[page]) if block["language"] in ("sh", "")]
    lines = [line.split(" #")[0].strip() for text in found for line in text.replace("\\\n", " ").splitlines()]
    return [line for line in lines if PROGRAM.match(line)]


def write_files(page: str, folder: Path) -> None:
    """Write the files that a page shows whole, for its commands."""
    for block in FENCED.finditer(PAGES[page]):
        named = FILE.match(block["text"])
        if block["language"] == "yaml" and named is not None:
            (folder / named["name"]).write_text(block["text"])


def elsewhere(line: str) -> str | None:
    return next((test for begin, test in ELSEWHERE.items() if re.match(begin, line)), None)


def run_here() -> list[str]:
    """Pages with commands that no other test runs."""
    return [page for page in PAGES if page != FOLLOWED and not all(map(elsewhere, shown(page)))]


@pytest.mark.parametrize("page", run_here())
def test_the_commands_of_a_page_work_one_after_the_other(
    page: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "graphs").symlink_to(ROOT / "graphs")
    write_files(page, tmp_path)
    for line in shown(page):
        if elsewhere(line) is None:
            command, _, file = line.partition(" > ")
            capsys.readouterr()
            assert main(shortened(command)) == 0, line
            if file:
                Path(file).write_text(capsys.readouterr().out)


def shortened(line: str) -> list[str]:
    """The command's words; of a run and of a simulation only the first pictures."""
    name, *words = shlex.split(re.sub(r" --frames \d+", "", line))
    assert name == "followspot", line
    few = {
        "run": ["--frames", "2", "--quiet"],
        "record": ["--frames", "2", "--quiet"],
        "replay": ["--quiet"],
        "simulate": ["--frames", "10"],
    }
    return [*words, *few.get(words[0], [])]


def test_the_parts_of_a_room_shown_track_every_ball(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "graphs").symlink_to(ROOT / "graphs")
    parts = [line for line in shown("composing.md") if "--cameras" in line]
    assert len(parts) == 2
    for line in parts:
        assert "--frames" not in line
        words = [*shlex.split(line)[1:], "--frames", "60", "--quiet", "--json"]
        assert main(words) == 0
        found = json.loads(capsys.readouterr().out)["targets"]
        assert min(target["coverage"] for target in found.values()) > 0.9, line


@pytest.mark.parametrize("begin", ELSEWHERE)
def test_what_is_run_elsewhere_is_still_shown_and_run(begin: str) -> None:
    assert any(re.match(begin, line) for page in PAGES for line in shown(page))
    assert (ROOT / ELSEWHERE[begin]).exists()
