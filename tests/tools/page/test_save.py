"""What was changed in a run is saved from the page, a script and the command line."""

from __future__ import annotations

import asyncio
import os
from pathlib import Path

import pytest

import followspot as fs
from followspot.cli.main import main
from followspot.errors import FollowspotError
from followspot.graph.compile import compile_graph
from followspot.graph.plan import Plan
from followspot_page.allowed_requests import request_of
from followspot_page.display.feed import Feed
from followspot_page.page import Page
from followspot_page.requests.handler import Requests

GRAPH = Path(__file__).parents[3] / "graphs" / "glowballs.yaml"


def stages(plan: Plan) -> dict[str, object]:
    return {stage.name: (stage.uses, dict(stage.params)) for stage in plan.stages}


def test_a_run_is_saved_as_it_was_changed(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with fs.run(GRAPH, out=tmp_path / "out", frames=500) as run:
        run.pause()
        run.set("color.similarity", 0.85)
        run.swap("fuse", "balls.mean")
        page = Page.__new__(Page)
        page.ask, page.scrub, page.feed = run, None, Feed()
        said = asyncio.run(Requests(page).do('{"save": true}')).text
        assert run.save(tmp_path / "script.yaml") == ("fuse", "color")
        assert main(["save", str(tmp_path / "command.yaml"), "--run", str(os.getpid())]) == 0
        present = run.plan()
        run.resume()
        run.stop()
    (saved,) = (tmp_path / "out").glob("overlay-*.yaml")
    assert str(saved) in said
    assert "changes fuse, color" in capsys.readouterr().out
    for path in (saved, tmp_path / "script.yaml", tmp_path / "command.yaml"):
        assert stages(compile_graph(path)) == stages(present)


def test_a_browser_asks_for_nothing_else() -> None:
    for text in ('{"save": false}', '{"save": "/etc/passwd"}'):
        with pytest.raises(FollowspotError, match="nothing that can be asked for"):
            request_of(text)
