"""What --dashboard and its relatives take."""

from __future__ import annotations

import argparse
from pathlib import Path

import pytest

from followspot.errors import FollowspotError, InputError
from followspot.graph.compile import compile_graph
from followspot.graph.plan import Plan
from followspot_page.hooks import configure, tapped
from followspot_page.showing import Address, folder, shown

GRAPH = Path(__file__).parents[3] / "graphs" / "glowballs.yaml"


def options(*given: str) -> argparse.Namespace:
    parser = argparse.ArgumentParser()
    configure(parser)
    return parser.parse_args(given)


@pytest.fixture(scope="module")
def plan() -> Plan:
    return compile_graph(GRAPH)


def test_without_the_option_the_plan_is_as_it_was(plan: Plan) -> None:
    assert tapped(plan, options()) is plan
    assert tapped(plan, argparse.Namespace()) is plan  # a command that has no such option


def test_taps_run_where_their_stages_do(plan: Plan) -> None:
    seen = tapped(plan, options("--dashboard"))
    worker = {stage.name: stage.worker for stage in seen.stages}
    added = seen.edges[len(plan.edges) :]
    assert {edge.from_stage.partition("/")[0] for edge in added} == {"camera", "color", "infrared", "track"}
    assert all(worker[edge.from_stage] == worker[edge.to_stage] for edge in added)
    assert seen.workers == plan.workers


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
        tapped(plan, options(*given))


def test_a_page_for_everybody_is_served_where_it_is_meant(plan: Plan) -> None:
    assert tapped(plan, options("--dashboard-at", "0.0.0.0:0", "--dashboard-open")) is not plan


def test_a_page_that_is_missing_a_package_says_which(plan: Plan, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None if name == "uvicorn" else name)
    with pytest.raises(InputError, match="needs uvicorn"):
        tapped(plan, options("--dashboard"))


def test_an_address_that_cannot_be_served_is_named_and_nothing_stays(plan: Plan) -> None:
    elsewhere = Address("192.0.2.1", 80, firm=True)
    with pytest.raises(FollowspotError, match=r"192\.0\.2\.1:80"), shown(plan, elsewhere):
        pass
    assert not folder().exists()
