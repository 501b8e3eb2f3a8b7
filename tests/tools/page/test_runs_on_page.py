"""The page lists the runs in reach, and opens the pages of those that have none."""

from __future__ import annotations

import json
import os
import time
import urllib.request
from pathlib import Path
from typing import Any

import pytest
from tests.tools.page.served import Shown, served

from followspot.control.unix_socket import serve_requests
from followspot.errors import FollowspotError
from followspot.graph.compile import compile_graph
from followspot_page.allowed_requests import OpenPage, request_of
from followspot_page.run_list import pages

GRAPH = Path(__file__).parents[3] / "graphs" / "glowballs.yaml"
TIMEOUT = 120.0


def listed(page: Shown) -> dict[str, Any]:
    """The runs by name."""
    status, text, _ = page.get("runs")
    assert status == 200, text
    return {run["run"]: run for run in json.loads(text)}


def answer_to(page: Shown, wish: str) -> dict[str, Any]:
    """What the page answers, once it takes wishes."""
    with page.look() as socket:
        deadline = time.monotonic() + TIMEOUT
        while time.monotonic() < deadline:
            socket.send(wish)
            while (told := json.loads(socket.recv(timeout=TIMEOUT)))["type"] != "answer":
                pass
            if "yet" not in told["text"]:
                found: dict[str, Any] = told
                return found
    raise AssertionError("the page takes no wishes")


def test_runs_in_reach_are_listed_until_they_end(tmp_path: Path) -> None:
    other, name = Shown(compile_graph(GRAPH), tmp_path), f"{os.getpid():x}other0123456789"
    with served(tmp_path) as page:
        with serve_requests(name, "other", other.dispatcher()):
            runs = listed(page)
            (own,) = (run for run in runs.values() if run["shown"])
            assert own["page"] == page.url
            assert (runs[name]["graph"], runs[name]["page"], runs[name]["shown"]) == ("other", "", False)
        assert name not in listed(page), "it has ended"
        assert not answer_to(page, json.dumps({"open": name}))["ok"]


def test_the_page_of_a_run_is_announced_as_long_as_it_is_served(tmp_path: Path) -> None:
    with served(tmp_path) as page:
        assert page.url in pages().values()
        with urllib.request.urlopen(page.url, timeout=60) as home:
            assert home.status == 200
        (own,) = (run for run in listed(page).values() if run["shown"])
        assert answer_to(page, json.dumps({"open": own["run"]}))["text"] == page.url, "it has one"
    assert page.url not in pages().values()


def test_a_run_is_named_by_its_name_alone() -> None:
    assert request_of('{"open": "ab"}') == OpenPage("ab")
    with pytest.raises(FollowspotError):
        request_of(json.dumps({"open": "x" * 65}))
