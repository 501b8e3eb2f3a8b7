"""`followspot compare`: variants of a graph, and what is refused before anything runs."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest
from tests.tools.compared import ROOT, SIMULATED

from followspot.cli.main import main
from followspot.cli.parser import build_parser
from followspot.errors import InputError
from followspot_compare.command import Scene, plan_scenes, unchanged
from followspot_compare.variants import Variant, read_variants

RECORDED = str(ROOT / "graphs/experiments/recorded.yaml")


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
