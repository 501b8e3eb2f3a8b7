"""What a shell offers, and what a wrong word may have meant."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

import pytest
from tests.commands import command

from followspot.cli.main import main
from followspot.control.dispatch import Dispatcher
from followspot.control.unix_socket import serve_requests
from followspot.graph.compile import compile_graph
from followspot.graph.plan_data import plan_to_data
from followspot.operator.run_requests import GetPlan

ROOT = Path(__file__).parents[3]
RUN = f"run{os.getpid():x}"
"""Name of a graph that runs; other runs may be on this machine."""


@pytest.fixture(scope="module")
def run() -> Iterator[None]:
    plan = compile_graph(ROOT / "graphs" / "glowballs.yaml")
    with serve_requests(
        f"{os.getpid():x}completed", RUN, Dispatcher("operator", {GetPlan: lambda _: plan_to_data(plan)})
    ):
        yield


def offered(line: str, folder: Path) -> set[str]:
    """What the shell gets for a line whose last word is not complete."""
    answer = folder / "completions"
    asks = {"_ARGCOMPLETE": "1", "COMP_LINE": line, "COMP_POINT": str(len(line)), "_ARGCOMPLETE_IFS": "\n"}
    command(env={**os.environ, **asks, "_ARGCOMPLETE_STDOUT_FILENAME": str(answer)}, cwd=ROOT, check=True)
    return {word.strip() for word in answer.read_text().splitlines()}


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("followspot calibrate pl", {"planes"}),
        ("followspot run graphs/gl", {"graphs/glowballs.yaml"}),
        ("followspot run --edges r", {"reference", "ring"}),
        ("followspot plugins balls.mea", {"balls.mean", "balls.mean_shift"}),
        ("followspot run graphs/glowballs.yaml --set color.sim", {"color.similarity="}),
        ("followspot compare graphs/glowballs.yaml --set color.u", {"color.uses="}),
        ("followspot run graphs/glowballs.yaml --set color/cam0.u", {"color/cam0.uses="}),
        ("followspot run graphs/show.yaml --set balls/color.sim", {"balls/color.similarity="}),
        ("followspot run graphs/show.yaml --record-ports balls/track.t", {"balls/track.tracks"}),
        (
            "followspot run graphs/glowballs.yaml --record-ports color,track.t",
            {"color,track.tracks"},
        ),
        ("followspot run README.md --set color.sim", set()),
        ("followspot export show.mcap --to csv tables --ports tr", set()),
    ],
)
def test_files_stages_parameters_and_ports_of_a_graph_are_offered(
    line: str, words: set[str], tmp_path: Path
) -> None:
    assert offered(line, tmp_path) == words


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("followspot top --run PART", {RUN}),
        ("followspot echo --run RUN track.", {"track.tracks", "track.forecast"}),
        ("followspot set --run RUN color.sim", {"color.similarity="}),
        ("followspot move --run RUN color/cam0 mai", {"main"}),
        ("followspot move --run RUN trac", {"track"}),
    ],
)
@pytest.mark.usefixtures("run")
def test_runs_and_their_stages_ports_and_workers_are_offered(
    line: str, words: set[str], tmp_path: Path
) -> None:
    named = line.replace("PART", RUN[:-1]).replace("RUN", RUN)  # test processes must agree on names of tests
    assert offered(named, tmp_path) == words


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_the_script_of_each_shell_names_the_command(shell: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["completion", shell]) == 0
    assert "followspot" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("line", "remedy"),
    [
        (["rnu", "graph.yaml"], 'did you mean "run"'),
        (["run", "graph.yaml", "--fraems=3"], 'did you mean "--frames"'),
        (["run", "graph.yaml", "--edges", "rign"], 'did you mean "ring"'),
        (["calibrate", "plane"], 'did you mean "planes"'),
    ],
)
def test_a_wrong_word_is_answered_with_what_it_may_have_meant(
    line: list[str], remedy: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as end:
        main(line)
    assert end.value.code == 2
    assert remedy in capsys.readouterr().err
