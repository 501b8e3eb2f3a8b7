"""Standard output of a calibration has its result alone, whatever the stages print that it runs."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from followspot.cli.main import main
from followspot.errors import FollowspotError
from followspot_calibrate import tracked

GRAPHS = Path(__file__).parents[3] / "graphs"


@pytest.mark.parametrize("command", ["clocks", "refine"])
def test_what_stages_print_goes_to_standard_error(
    command: str, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    def run(*_: object) -> None:
        print("a stage")
        os.write(1, b"its library\n")
        raise FollowspotError("ended")

    monkeypatch.setattr(tracked, "run_plan", run)
    room = GRAPHS / "rooms" / "simulated.yaml"
    words = ["--room", str(room), "--graph", str(GRAPHS / "glowballs.yaml"), "--frames", "2", "--json"]
    assert main(["calibrate", command, *words]) == 1
    said = capfd.readouterr()
    assert said.out == ""
    assert {"a stage", "its library"} <= set(said.err.splitlines())
