"""What --dashboard and its relatives take."""

from __future__ import annotations

import argparse
import os
from pathlib import Path

import pytest

from followspot.errors import FollowspotError, InputError
from followspot.graph.change.stages import change_of
from followspot.graph.compile import compile_graph
from followspot.graph.plan import Plan
from followspot_page.allowed_requests import sentence
from followspot_page.hooks import checked, configure
from followspot_page.options import order_of
from followspot_page.page_process import PageOrder, shown
from followspot_page.taps.shown_ports import longest_side, shown_ports, tappings

GRAPH = Path(__file__).parents[3] / "graphs" / "glowballs.yaml"


def options(*given: str) -> argparse.Namespace:
    parser = argparse.ArgumentParser()
    configure(parser)
    return parser.parse_args(given)


@pytest.fixture(autouse=True)
def bundled(monkeypatch: pytest.MonkeyPatch) -> None:
    """Options are read alike whether the page's files are there or not."""
    monkeypatch.setattr("followspot_page.options.check_bundle", lambda: None)


@pytest.fixture(scope="module")
def plan() -> Plan:
    return compile_graph(GRAPH)


def test_the_plan_is_as_it_was(plan: Plan) -> None:
    assert checked(plan, options("--dashboard")) is plan
    assert checked(plan, options()) is plan
    assert checked(plan, argparse.Namespace()) is plan  # a command that has no such option


def test_what_is_looked_at_are_the_ports_that_can_be_shown(plan: Plan) -> None:
    found = tappings(shown_ports(plan), Path("page"), rate=5.0)
    assert {tap.port.partition("/")[0] for tap in found} == {
        *("camera", "color", "infrared"),
        *("track.tracks", "track.forecast"),
    }
    assert {tap.port for tap in found if tap.params["sets_times"]} == {f"camera/cam{i}.out" for i in range(6)}


@pytest.mark.parametrize(
    ("given", "why"),
    [
        (["--dashboard-at", "0.0.0.0:8777"], "--dashboard-open"),
        (["--dashboard-at", "studio.local:8777"], "--dashboard-open"),
        (["--dashboard-at", "here"], "HOST:PORT"),
        (["--dashboard-at", "127.0.0.1:99999"], "HOST:PORT"),
        (["--dashboard-at", ":1"], "HOST:PORT"),
        (["--dashboard", "--dashboard-rate", "0"], "--dashboard-rate"),
        (["--dashboard", "--dashboard-rate", "nan"], "--dashboard-rate"),
    ],
)
def test_what_cannot_be_or_must_be_meant_is_refused(plan: Plan, given: list[str], why: str) -> None:
    with pytest.raises(InputError, match=why):
        checked(plan, options(*given))


def test_a_page_for_everybody_is_served_where_it_is_meant() -> None:
    order = order_of(options("--dashboard-at", "[::]:0", "--dashboard-open"))
    assert order == PageOrder(os.getpid(), "::", 0, firm=True)


def test_a_page_that_is_missing_a_package_says_which(plan: Plan, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None if name == "uvicorn" else name)
    with pytest.raises(InputError, match="needs uvicorn"):
        checked(plan, options("--dashboard"))


def test_an_address_that_cannot_be_served_is_named() -> None:
    elsewhere = PageOrder(os.getpid(), "192.0.2.1", 80)
    with pytest.raises(FollowspotError, match=r"192\.0\.2\.1:80"), shown(elsewhere):
        pass


def test_previews_have_as_many_pixels_whatever_their_shape() -> None:
    assert longest_side((640, 480)) == longest_side((320, 240)) == 320
    width = longest_side((1396, 260))
    assert width * width * 260 / 1396 == pytest.approx(320 * 240, rel=0.01)
    assert longest_side((240, 320)) == 320
    assert longest_side((10_000, 10)) == 1280


def test_what_is_wrong_with_a_value_is_one_sentence(plan: Plan) -> None:
    for words, told in {
        "color.minimum_area=-7": '"minimum_area" cannot be -7: it must be greater than 0',
        "color.minimum_area=7": "minimum_area 7 is more than maximum_area 1.5",
    }.items():
        with pytest.raises(InputError) as caught:
            change_of(plan, [words])
        assert sentence(str(caught.value)) == told
    assert sentence("the run has ended") == "the run has ended"
