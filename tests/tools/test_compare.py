"""`followspot compare`: variants, runs, figures, pictures; and the commands in docs/experiments."""

from __future__ import annotations

import json
import math
import re
import shlex
import signal
import sys
from dataclasses import replace
from pathlib import Path

import pytest
from tests.commands import launch
from tests.full_disk import full_disk
from tests.integration.running import wait_until

from followspot.cli.main import main
from followspot.cli.parser import build_parser
from followspot.errors import FollowspotError, InputError
from followspot_accuracy import TargetScore
from followspot_accuracy.targets.metrics import Recoveries
from followspot_compare.columns import COLUMNS
from followspot_compare.command import Scene, comparable, plan_scenes, unchanged
from followspot_compare.plot import MISSING, draw
from followspot_compare.report import Comparison, data, text
from followspot_compare.trial import TargetFigures, Trial
from followspot_compare.variants import Variant, read_variants

ROOT = Path(__file__).parents[2]
RECORDED = str(ROOT / "graphs/experiments/recorded.yaml")
SIMULATED = str(ROOT / "graphs/rooms/simulated.yaml")
PANORAMA = str(ROOT / "graphs/rooms/simulated_panorama.yaml")
PAGES = (ROOT / "docs/experiments.md", *sorted((ROOT / "docs/experiments").glob("*.md")))


def figures(rmse: float = 5.0, **score: object) -> TargetFigures:
    values: dict[str, object] = {
        "frames": 100,
        "coverage": 1.0,
        "rmse_mm": rmse,
        "median_mm": rmse,
        "p95_mm": 2 * rmse,
        "identity_switches": 0,
        "hidden_frames": 0,
        "false_positions": 0,
        "false_share": math.nan,
        "recovery_frames": (),
        "recovery_worst": 0,
        "jerk_cost": 0.001,
        "reprojection_px": 0.2,
        "reprojection_std_px": 0.1,
    }
    return TargetFigures(TargetScore(**{**values, **score}), 0.001, math.nan, math.nan, math.nan, math.nan)


def trial(variant: str, room: str, iterations: tuple[int, ...] = (), **targets: TargetFigures) -> Trial:
    return Trial(variant, room, 100, 2.0, 1.5, targets, iterations)


def column(key: str, *of: TargetFigures) -> float:
    return next(c for c in COLUMNS if c.key == key).of(of)


def test_each_graph_is_a_variant_and_each_option_changes_the_first() -> None:
    options = ["both:fuse.uses=balls.mean,verify.in.blobs=[color, infrared],verify.homography_tolerance=0"]
    variants = read_variants(["graphs/a.yaml", "b.yaml"], options)
    assert [(v.name, v.graph) for v in variants] == [
        ("a", "graphs/a.yaml"),
        ("b", "b.yaml"),
        ("both", "graphs/a.yaml"),
    ]
    assert variants[2].overrides == (
        "fuse.uses=balls.mean",
        "verify.in.blobs=[color, infrared]",
        "verify.homography_tolerance=0",
    )


@pytest.mark.parametrize(
    ("graphs", "options", "says"),
    [
        (["a.yaml"], ["fuse.uses=balls.mean"], "is no variant"),
        (["a.yaml"], ["mean:"], "is no variant"),
        (["a.yaml"], ["../up:fuse.uses=balls.mean"], 'cannot be named "../up"'),
        (["a.yaml"], [".hidden:fuse.uses=balls.mean"], 'cannot be named ".hidden"'),
        (["x/a.yaml", "y/a.yaml"], [], '2 variants are named "a"'),
        (["a.yaml"], ["a:fuse.uses=balls.mean"], '2 variants are named "a"'),
    ],
)
def test_variants_that_cannot_be_told_apart_or_read_are_refused(
    graphs: list[str], options: list[str], says: str
) -> None:
    with pytest.raises(InputError, match=re.escape(says)):
        read_variants(graphs, options)


def test_variants_run_on_the_same_recording_and_are_held_against_the_first(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    arguments = ["--variant", "mean:fuse.uses=balls.mean", "--frames", "8", "-o", str(tmp_path)]
    assert main(["compare", RECORDED, *arguments, "--quiet", "--json"]) == 0
    result = json.loads(capsys.readouterr().out)
    assert result["variants"] == ["recorded", "mean"]
    first, mean = result["trials"]
    ratio = result["means"]["mean"]["rmse_mm"] / result["means"]["recorded"]["rmse_mm"]
    assert result["ratios"]["mean"]["rmse_mm"] == ratio != 1.0
    assert set(result["ratios"]["recorded"].values()) == {1.0}
    assert first["targets"]["red"]["detection_px"] > 0
    assert sum(first["iterations"][1:]) > 0
    assert mean["iterations"] == [sum(mean["iterations"])]
    assert (tmp_path / "simulated/mean/tracks.csv").is_file()
    assert json.loads((tmp_path / "compare.json").read_text()) == result
    assert result["unchanged"] == []


def test_a_variant_that_writes_the_files_of_the_first_is_named(tmp_path: Path) -> None:
    variants = [Variant(name, "a.yaml", ()) for name in ("first", "same", "other", "half")]
    scenes = [Scene("hall", ()), Scene("stage", ())]
    for scene in scenes:
        for variant in variants:
            folder = tmp_path / scene.name / variant.name
            folder.mkdir(parents=True)
            differs = variant.name == "other" or (variant.name == "half" and scene.name == "stage")
            (folder / "tracks.csv").write_text("2" if differs else "1")
    assert unchanged(variants, scenes, tmp_path) == ("same",)


def test_mistakes_of_all_variants_come_at_once_and_nothing_runs(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    options = ["--variant", "a:fusion.uses=balls.mean", "--variant", "b:fuse.bandwith=3"]
    assert main(["compare", RECORDED, *options, "-o", str(tmp_path / "out")]) == 2
    said = capsys.readouterr().err
    assert 'no stage "fusion"' in said
    assert "bandwith" in said
    assert not (tmp_path / "out").exists()


def test_an_option_of_a_variant_takes_the_place_of_that_of_all_variants() -> None:
    words = ["compare", RECORDED, "--set", "fuse.uses=balls.mean", "--variant", "b:fuse.uses=balls.bundle"]
    args = build_parser(words).parse_args(words)
    (scene,) = plan_scenes(read_variants(args.graphs, args.variants), args)
    used = [stage.uses for plan in scene.plans for stage in plan.stages if stage.name == "fuse"]
    assert used == ["balls.mean", "balls.bundle"]


def test_room_without_truth_cannot_be_compared_in(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    blind = tmp_path / "blind.yaml"
    blind.write_text(re.sub(r"^truth:.*\n", "", Path(SIMULATED).read_text(), flags=re.MULTILINE))
    assert main(["compare", RECORDED, "--room", str(blind)]) == 2
    assert "knows no ground truth" in capsys.readouterr().err


def test_rooms_of_one_name_are_refused(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["compare", RECORDED, "--room", SIMULATED, "--room", SIMULATED]) == 2
    assert 'several rooms are named "simulated"' in capsys.readouterr().err


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
    options = ["--plugin", str(folder / "slow.py"), "--frames", "20", "-o", str(folder / "out")]
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


def test_several_targets_share_a_mean_a_sum_or_the_worst() -> None:
    a = figures(4.0, identity_switches=1, hidden_frames=10, false_positions=1, recovery_frames=(2, 7))
    b = figures(8.0, identity_switches=2, hidden_frames=30, false_positions=1, recovery_frames=(3,))
    nothing = figures(math.nan, frames=0)
    assert column("rmse_mm", a, b, nothing) == 6.0
    assert column("switches", a, b) == 3
    assert column("false_percent", a, b, nothing) == 5.0
    assert column("recovery_frames", a, b) == 7
    assert math.isnan(column("recovery_frames", nothing))
    assert math.isnan(column("rmse_mm"))
    ghost = figures(math.nan, frames=0, coverage=math.nan, jerk_cost=9.0, identity_switches=1)
    assert column("jerk_cost", a, ghost) == 0.001
    assert column("switches", a, ghost) == 2


def test_errors_within_the_ellipsoid_are_a_share_of_the_frames_of_all_targets() -> None:
    a = figures(rated_frames=30, within_95=0.9, bridged_frames=4, bridged_within_95=0.5)
    b = figures(rated_frames=10, within_95=0.5)
    assert column("within_95_percent", a, b) == pytest.approx(80.0)
    assert column("bridged_within_95_percent", a, b) == 50.0
    assert math.isnan(column("within_95_percent", figures()))
    assert math.isnan(column("bridged_within_95_percent", b))


def test_false_recoveries_are_a_share_of_all_recoveries_and_of_all_frames_sought() -> None:
    a = replace(figures(), recovery=Recoveries(sought=60, found=3, false=1), pairs=(12.0, 10.0, 18.0))
    b = replace(figures(), recovery=Recoveries(sought=40, found=1, false=0), pairs=(14.0, 8.0, 15.0))
    ghost = replace(figures(frames=0), recovery=Recoveries(sought=100, found=1, false=1))
    assert column("false_recovery_percent", a, b) == 25.0
    assert column("false_recovery_percent", a, b, ghost) == 40.0
    assert column("false_sought_percent", a, b) == 1.0
    assert math.isnan(column("false_recovery_percent", figures()))
    assert [column(key, a, b, ghost) for key in ("pairs", "pairs_p5", "pairs_p95")] == [13.0, 9.0, 16.5]


def test_ratio_compares_means_over_all_rooms_with_those_of_the_first_variant() -> None:
    trials = (
        trial("plain", "hall", (0, 3, 1), red=figures(4.0)),
        trial("plain", "attic", (0, 0, 0, 2), red=figures(8.0)),
        trial("other", "hall", (4,), red=figures(6.0), ghost=figures(math.nan, hidden_frames=9)),
        trial("other", "attic", (2,), red=figures(12.0)),
    )
    comparison = Comparison(trials)
    assert comparison.ratio("other", "rmse_mm") == 1.5
    assert comparison.iterations("plain") == (0, 3, 1, 2)
    assert data(comparison)["means"]["other"]["false_percent"] == 0.0
    shown = text(comparison)
    assert "hall, ghost" in shown
    assert re.search(r"ratio to plain\n +other +1\.50", shown)
    assert re.search(r"plain +200 +50 +1\.50 ms", shown)


def test_without_matplotlib_the_tables_remain_and_it_says_how_to_get_plots(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "matplotlib.figure", None)
    assert draw(Comparison((trial("plain", "hall", red=figures()),)), tmp_path) == MISSING
    assert 'pip install "followspot[plots]"' in MISSING
    assert not list(tmp_path.iterdir())


def test_pictures_are_drawn_and_the_same_again(tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    trials = (trial("plain", "hall", (0, 9, 1), red=figures(4.0)), trial("bad", "hall", red=figures(400.0)))
    for folder in (tmp_path / "a", tmp_path / "b"):
        folder.mkdir()
        assert "errors.svg" in draw(Comparison(trials), folder)
    for name in ("errors.svg", "iterations.svg"):
        picture = (tmp_path / "a" / name).read_bytes()
        assert b"plain" in picture
        assert picture == (tmp_path / "b" / name).read_bytes()


def commands() -> list[str]:
    text = "\n".join(page.read_text() for page in PAGES)
    shown = "\n".join(re.findall(r"```sh\n(.*?)```", text, re.DOTALL)).replace("\\\n", " ")
    return [line for line in shown.splitlines() if line.startswith("followspot ")]


def test_the_pages_show_commands() -> None:
    assert len(commands()) > 5


@pytest.mark.parametrize("line", commands())
def test_every_command_of_the_pages_is_understood_and_its_variants_can_be_planned(
    line: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(ROOT)
    words = shlex.split(line)[1:]
    args = build_parser(words).parse_args(words)
    assert callable(args.run_command)
    for path in re.findall(r"graphs/\S+\.(?:yaml|py)", line):
        assert Path(path).is_file()
    if line.startswith("followspot compare "):
        args.rooms = [PANORAMA if "persons.yaml" in line else SIMULATED]
        assert plan_scenes(read_variants(args.graphs, args.variants), args)


def test_every_picture_of_the_pages_is_there() -> None:
    shown = [(page, path) for page in PAGES for path in re.findall(r"!\[.*?\]\((.*?)\)", page.read_text())]
    assert shown
    for page, path in shown:
        assert (page.parent / path).stat().st_size > 5_000
