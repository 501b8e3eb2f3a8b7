"""`followspot score --plot` of tracks: trajectories over time and in space, beside the truth."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from followspot.cli.main import main
from followspot_accuracy import TrackTable, TruthTable
from followspot_score import trajectories
from followspot_score.trajectories import alone, color_of, draw_trajectories, within

TIME = np.arange(30) / 30


def truth(names: tuple[str, ...] = ("red",)) -> TruthTable:
    place = np.zeros((30, len(names), 3))
    place[..., 0] = TIME[:, None] + np.arange(len(names))
    seen = np.ones((30, len(names)), bool)
    return TruthTable(names, TIME, place, ~seen, seen, seen)


def tracks(frames: list[int], name: str = "red") -> TrackTable:
    count = len(frames)
    place = np.column_stack([TIME[frames], np.zeros((count, 2))])
    return TrackTable((name,), TIME[frames], np.zeros(count, int), np.ones(count, "u1"), place)


def drawn_lines(monkeypatch: pytest.MonkeyPatch, folder: Path, *what: object) -> list[list[np.ndarray]]:
    """x and y of the lines of the uppermost panel over time that are as long as the recording."""
    figures = []
    axes = pytest.importorskip("matplotlib.axes").Axes
    plot = axes.plot

    def noted(self: object, *args: object, **style: object) -> object:
        figures.append((self, args))
        return plot(self, *args, **style)

    monkeypatch.setattr(axes, "plot", noted)
    draw_trajectories(*what, folder, None)  # type: ignore[arg-type]
    first = figures[0][0]
    return [[np.array(part) for part in args] for own, args in figures if own is first and len(args[0])]  # type: ignore[arg-type]


def test_a_frame_without_a_position_is_a_gap_in_the_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    frames = [*range(10), *range(20, 30)]
    reported, true = drawn_lines(monkeypatch, tmp_path, tracks(frames), truth())
    assert np.isnan(reported[1][10:20]).all()
    assert reported[1][frames] == pytest.approx(TIME[frames])
    assert true[1] == pytest.approx(TIME)


def test_a_position_between_two_gaps_is_a_dot() -> None:
    xyz = np.full((6, 3), np.nan)
    xyz[[0, 2, 3, 5]] = 0.0
    assert alone(xyz).tolist() == [True, False, False, False, False, True]


def test_pictures_name_every_target_and_are_the_same_again(tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    for folder in (tmp_path / "a", tmp_path / "b"):
        said = draw_trajectories(tracks([3, 4]), truth(("red", "my box")), folder, None)
        assert str(folder / "trajectories.svg") in said
    for name in ("trajectories.svg", "trajectories_3d.svg"):
        picture = (tmp_path / "a" / name).read_bytes()
        assert all(word in picture for word in (b"red", b"my box", b"truth"))
        assert picture == (tmp_path / "b" / name).read_bytes()


def test_a_target_that_the_truth_does_not_know_is_drawn_too(tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    draw_trajectories(tracks([3, 4], "ghost"), truth(), tmp_path, None)
    assert "ghost" in (tmp_path / "trajectories.svg").read_text()


def test_a_span_of_time_holds_both_ends() -> None:
    assert within(truth(), (TIME[10], TIME[20])).time.tolist() == TIME[10:21].tolist()
    assert len(within(truth(), None).time) == 30


def test_targets_have_the_color_they_are_named_after_if_it_is_readable() -> None:
    pytest.importorskip("matplotlib")
    assert color_of("red", 3) == "red"
    assert color_of("yellow", 3) != "yellow"
    assert color_of("my box", 3) == trajectories.PALETTE[3]


def files(folder: Path) -> list[str]:
    (folder / "tracks.csv").write_text("frame,time,object,state,x,y,z\n0,0.0,red,tracked,0,0,1\n")
    header = "frame,time,object,x,y,z,hidden,trackable,pair\n"
    rows = "".join(f"{i},{i / 30},red,0,0,1,0,1,1\n" for i in range(3))
    (folder / "truth.csv").write_text(header + rows)
    return ["score", str(folder / "tracks.csv"), str(folder / "truth.csv")]


def test_the_command_draws_and_prints_the_scores(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("matplotlib")
    arguments = [*files(tmp_path), "--plot", str(tmp_path / "out"), "--between", "0", "0.05"]
    assert main(arguments) == 0
    said = capsys.readouterr().out
    assert "coverage" in said
    assert "trajectories_3d.svg" in said
    assert main([*arguments, "--json"]) == 0
    assert capsys.readouterr().out.startswith("{")


def test_without_matplotlib_it_says_how_to_get_plots(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(__import__("sys").modules, "matplotlib", None)
    assert main([*files(tmp_path), "--plot", str(tmp_path / "out")]) == 0
    assert "followspot[plots]" in capsys.readouterr().out


def test_several_truths_are_for_poses(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    arguments = files(tmp_path)
    assert main([*arguments, arguments[-1]]) == 2
    assert "several files of truth are for poses" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("span", "said"),
    [
        (("2", "1"), "--between 2 1 is no span of time"),
        (("0.02", "0.02"), "is no span of time"),
        (("nan", "1"), "is no span of time"),
        (("0", "nan"), "is no span of time"),
        (("0", "inf"), "is no span of time"),
        (("-3", "-1"), "is between -3 and -1 s"),
        (("5", "6"), "is between 5 and 6 s"),
        (("0.04", "0.05"), "is between 0.04 and 0.05 s"),
    ],
)
def test_a_span_in_which_nothing_is_is_refused(
    tmp_path: Path, span: tuple[str, str], said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main([*files(tmp_path), "--plot", str(tmp_path / "out"), "--between", *span]) == 2
    assert said in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_a_span_without_a_drawing_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([*files(tmp_path), "--between", "0", "1"]) == 2
    assert "add --plot DIR" in capsys.readouterr().err


@pytest.mark.parametrize("area", [("2", "0", "1", "3"), ("0", "0", "1", "nan"), ("0", "3", "1", "3")])
def test_an_area_without_a_place_in_it_is_refused(
    tmp_path: Path, area: tuple[str, ...], capsys: pytest.CaptureFixture[str]
) -> None:
    assert main([*files(tmp_path), "--area", *area]) == 2
    assert "is no area" in capsys.readouterr().err
