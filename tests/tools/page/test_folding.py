"""Sub-graphs on the page: one card each until it is unfolded."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest
from tests.tools.page.browser import CHROMIUM, Browser, browser
from tests.tools.page.served import GRAPH, Shown, served

from followspot.control.host import WorkerStatus
from followspot.control.stage_status import EdgeAge, StageStatus
from followspot.graph.compile import compile_graph
from followspot.graph.plan import Plan
from followspot.operator.run_status import RunStatus
from followspot.worker.ledger import COLUMNS, DELIVERED, DROPPED, PRODUCED
from followspot_page.page import Page

GRAPHS = GRAPH.parent
ZONES = f"graph: zones\noutputs: {{tracks: hall.tracks}}\nstages: {{hall: {{graph: {GRAPH}}}}}\n"
MAIN = f"""\
graph: main
room: {GRAPHS}/rooms/simulated.yaml
stages:
  all:   {{graph: zones.yaml}}
  smooth: {{uses: sinks.csv, in: {{tracks: all.tracks}}, with: {{path: all.csv}}}}
"""
LABEL = "querySelector('b').firstChild.textContent"
SEEN = "[...document.querySelectorAll('#pipeline li > button')].filter((b) => b.checkVisibility())"
CARDS = f"{SEEN}.map((b) => b.{LABEL})"
INNER = [
    "camera",
    "color",
    "infrared",
    "verify",
    "triangulate",
    "associate",
    "fuse",
    "bridge",
    "track",
    "save",
]


Opened = tuple[Shown, Browser]


@pytest.fixture(scope="module")
def opened(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Opened]:
    """The page of the nested graph on a phone."""
    folder = tmp_path_factory.mktemp("nested")
    plan = nested(folder)
    with served(folder, plan) as page, browser(folder / "chromium") as chromium:
        page.status = status(plan, "getting")
        chromium.open(page.url, 390, 844)
        chromium.wait("document.querySelector('#life')?.dataset.life === 'running'")
        yield page, chromium


def nested(folder: Path) -> Plan:
    """The glowing balls within a sub-graph within a sub-graph."""
    (folder / "zones.yaml").write_text(ZONES, encoding="utf-8")
    (folder / "main.yaml").write_text(MAIN, encoding="utf-8")
    return compile_graph(folder / "main.yaml")


def status(plan: Plan, verify: str) -> RunStatus:
    """verify: what the stage of that name is doing. Each edge has lost two messages."""
    counts = [0] * (COLUMNS * len(plan.edges))
    for number in range(len(plan.edges)):
        for column, count in {PRODUCED: 9, DELIVERED: 7, DROPPED: 2}.items():
            counts[COLUMNS * number + column] = count
    out = next(edge.name for edge in plan.edges if edge.to_stage == "smooth")
    stages = tuple(
        StageStatus(
            stage.name,
            verify if stage.group.endswith("verify") else "getting",  # type: ignore[arg-type]
            fired=7,
            edges=(EdgeAge(out, 4.0, 9.0),) if stage.name == "smooth" else (),
        )
        for stage in plan.stages
    )
    return RunStatus((WorkerStatus("main", "running", 7, stages=stages, age_s=0.1),), tuple(counts), 7, None)


def press(chromium: Browser, name: str) -> None:
    """Click on the card of this name."""
    chromium.ask(f"{SEEN}.find((b) => b.{LABEL} === {name!r}).click()")


def test_the_page_tells_what_holds_a_stage_as_the_plan_does(tmp_path: Path) -> None:
    page = Page(nested(tmp_path), None, tmp_path)  # type: ignore[arg-type]  # no browser needs the gate
    stages = {stage["name"]: stage for stage in page.about()["stages"]}
    assert stages["all/hall/fuse"]["within"] == ["all", "all/hall"]
    assert [stages[name]["label"] for name in ("all/hall/fuse", "smooth")] == ["fuse", "smooth"]
    assert stages["smooth"]["within"] == []


@pytest.mark.skipif(CHROMIUM is None, reason="needs chromium")
def test_a_sub_graph_is_one_card_that_unfolds_and_stays_so(opened: Opened) -> None:
    page, chromium = opened
    plan = page.plan
    assert chromium.ask(CARDS) == ["all", "smooth"]
    inside = sum(edge.to_stage != "smooth" for edge in plan.edges)
    card = "document.querySelector('#pipeline .subgraph > button').innerText"
    chromium.wait(f"/{2 * inside} not delivered/.test({card})")
    told = chromium.ask(card)
    assert "10 stages" in told
    assert "waiting for input" in told
    assert "latency 4.0 / 9.0 ms" in told

    page.status = status(plan, "sending")
    chromium.wait(f"/blocked by/.test({card})")  # the worst within
    press(chromium, "all")
    assert chromium.ask(CARDS) == ["all", "hall", "smooth"]
    press(chromium, "hall")
    assert chromium.ask(CARDS) == ["all", "hall", *INNER, "smooth"]
    assert chromium.ask("document.documentElement.scrollWidth") <= 390
    press(chromium, "fuse")
    assert chromium.ask("document.querySelector('#detail h2').textContent").startswith("all/hall/fuse · ")

    field = "[...document.querySelectorAll('.field')].find((f) => /^maximum_iterations/.test(f.innerText))"
    enter = "const i = {}.querySelector('input'); i.value = {}; i.dispatchEvent(new Event('change'));"
    chromium.wait(f"Boolean({field})")  # what can be changed is told later than the graph
    chromium.ask(enter.format(field, -1))
    chromium.wait(f"{field}.querySelector('[data-ok=false]')?.innerText.endsWith('must be at least 1')")
    assert chromium.ask("document.querySelectorAll('[data-ok=false]').length") == 1
    assert "30 by default" in chromium.ask(f"{field}.innerText")  # without hovering

    page.status = status(plan, "waiting")
    chromium.wait("document.querySelector('#pipeline .subgraph .state').dataset.state === 'waiting'")
    fuse = {"maximum_iterations": 77}
    changed = [replace(stage, params={**stage.params, **fuse}) for stage in plan.stages]
    page.plan = replace(plan, stages=tuple(changed))
    with page.look() as other:  # the answer to a change brings the present plan
        other.send(json.dumps({"stage": "all/hall/fuse", "key": "maximum_iterations", "value": "50"}))
    chromium.wait("[...document.querySelectorAll('#detail input')].some(({ value }) => value === '77')")
    assert chromium.ask(CARDS) == ["all", "hall", *INNER, "smooth"]

    press(chromium, "hall")
    assert chromium.ask(CARDS) == ["all", "hall", "smooth"]
    assert chromium.ask("document.querySelector('#detail').hidden")  # its card cannot be seen
    chromium.call("Page.reload")
    chromium.wait("document.querySelectorAll('#pipeline button').length > 2")
    assert chromium.ask(CARDS) == ["all", "hall", "smooth"]
    press(chromium, "all")
    assert chromium.ask(CARDS) == ["all", "smooth"]
    assert chromium.errors == []
