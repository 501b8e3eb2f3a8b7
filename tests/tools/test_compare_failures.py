"""`followspot compare` if a variant fails, the user interrupts, or the figures cannot be written."""

from __future__ import annotations

import json
import re
import signal
from pathlib import Path

import pytest
from tests.commands import launch
from tests.full_disk import full_disk
from tests.integration.running import wait_until
from tests.tools.compared import ROOT, SIMULATED, figures, trial

from followspot.cli.main import main
from followspot.errors import FollowspotError
from followspot_compare.command import comparable
from followspot_compare.plot import draw
from followspot_compare.report import Comparison


def test_failing_variant_is_named_after_the_figures_of_the_others_and_the_exit_code_is_1(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    plugin = tmp_path / "broken.py"
    plugin.write_text(
        "from followspot import Stage\n"
        "from followspot.tracking import Candidates, Positions\n"
        "class Fusion(Stage):\n"
        "    def process(self, candidates: Candidates) -> Positions:\n"
        "        raise ValueError('no such mode')\n"
    )
    graph = tmp_path / "graph.yaml"
    text = Path(ROOT / "graphs/glowballs.yaml").read_text().replace("rooms/simulated.yaml", SIMULATED)
    graph.write_text(re.sub(r"(fuse: .*candidates: associate.candidates), forecast: .*", r"\1}}", text))
    command = ["compare", str(graph), "--plugin", str(plugin), "--variant", "broken:fuse.uses=broken.fusion"]
    assert main([*command, "--frames", "2", "-o", str(tmp_path / "out"), "--quiet", "--json"]) == 1
    said = capsys.readouterr()
    assert 'variant "broken" failed in room simulated' in said.err
    assert "no such mode" in said.err
    known = json.loads(said.out)
    assert known["variants"] == ["graph"]
    assert json.loads((tmp_path / "out/compare.json").read_text()) == known


SLOW = """
import time
from pathlib import Path
from followspot import Stage
from followspot.tracking import Tracks

class Slow(Stage):
    def process(self, tracks: Tracks) -> None:
        Path(__file__).with_name("came").touch()
        time.sleep(0.2)
"""


def with_a_slow_variant(folder: Path, slow: str = SLOW) -> list[str]:
    """The command of a comparison whose second variant has one more stage."""
    (folder / "slow.py").write_text(slow)
    (folder / "quick.yaml").write_text(f"graph: quick\nextends: {ROOT}/graphs/glowballs.yaml\n")
    stage = "stages:\n  more: {uses: slow.slow, in: {tracks: track}}\n"
    (folder / "more.yaml").write_text(f"graph: more\nextends: quick.yaml\n{stage}")
    graphs = [str(folder / name) for name in ("quick.yaml", "more.yaml")]
    options = ["--plugin", str(folder / "slow.py"), "--frames", "100", "-o", str(folder / "out")]
    return ["compare", *graphs, *options, "--quiet", "--json"]


def test_ctrl_c_leaves_the_figures_of_the_variants_before(tmp_path: Path) -> None:
    process = launch(*with_a_slow_variant(tmp_path))
    assert wait_until((tmp_path / "came").exists, 60.0)
    process.send_signal(signal.SIGINT)
    out, errors = process.communicate(timeout=60)
    assert (process.wait(), errors.strip()) == (130, "followspot: interrupted")
    known = json.loads(out)
    assert known["variants"] == ["quick"]
    assert json.loads((tmp_path / "out/compare.json").read_text()) == known


def test_ctrl_c_is_an_interruption_although_the_figures_cannot_be_written(tmp_path: Path) -> None:
    (tmp_path / "out/compare.json").mkdir(parents=True)
    process = launch(*with_a_slow_variant(tmp_path))
    assert wait_until((tmp_path / "came").exists, 60.0)
    process.send_signal(signal.SIGINT)
    out, errors = process.communicate(timeout=60)
    assert process.wait() == 130, errors
    assert "compare.json cannot be written: Is a directory" in errors
    assert json.loads(out)["variants"] == ["quick"]


def test_a_variant_that_failed_is_named_although_the_figures_cannot_be_written(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "out/compare.json").mkdir(parents=True)
    assert main(with_a_slow_variant(tmp_path, SLOW.replace("time.sleep(0.2)", "1 / 0"))) == 1
    said = capsys.readouterr()
    assert 'variant "more" failed' in said.err
    assert "compare.json cannot be written: Is a directory" in said.err
    assert json.loads(said.out)["variants"] == ["quick"]


def test_a_picture_that_a_full_disk_cuts_short_is_named(tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    comparison = Comparison((trial("plain", "hall", red=figures()),))
    with full_disk(10), pytest.raises(FollowspotError, match=r"errors\.svg cannot be written: File too"):
        draw(comparison, tmp_path)


def test_what_is_compared_after_a_failure_are_the_rooms_that_all_variants_ran_in() -> None:
    hall = [trial("a", "hall"), trial("b", "hall")]
    assert comparable([*hall, trial("a", "stage")], 2) == tuple(hall)
    assert comparable([hall[0]], 2) == (hall[0],)
    assert comparable([], 2) == ()
