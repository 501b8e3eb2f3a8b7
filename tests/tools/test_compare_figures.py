"""The figures and pictures of `followspot compare`."""

from __future__ import annotations

import math
import re
import sys
from dataclasses import replace
from pathlib import Path

import pytest
from tests.tools.compared import figures, trial

from followspot_accuracy.targets.metrics import Recoveries
from followspot_compare.columns import COLUMNS
from followspot_compare.plot import MISSING, draw
from followspot_compare.report import Comparison, data, text
from followspot_compare.trial import TargetFigures


def column(key: str, *of: TargetFigures) -> float:
    return next(c for c in COLUMNS if c.key == key).of(of)


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
