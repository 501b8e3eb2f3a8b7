"""Broken inputs of every kind, a few of each; `python tools/fuzz.py` tries a hundred thousand."""

from __future__ import annotations

import importlib
import json
import random
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

FUZZ = Path(__file__).parents[2] / "tools" / "fuzz.py"


SOME = ["zenoh", "ring", "graph", "tables", "request", "registry", "video"]


@pytest.fixture(
    scope="module", params=[SOME, pytest.param([], marks=pytest.mark.thorough)], ids=["some", "all"]
)
def outcomes(request: pytest.FixtureRequest) -> dict[str, Any]:
    only = ["--only", *request.param] if request.param else []
    words = [sys.executable, str(FUZZ), "--share", "0.002", "--seed", "11", "--json", *only]
    done = subprocess.run(words, capture_output=True, text=True, check=False)
    assert done.stdout, done.stderr
    found: dict[str, Any] = json.loads(done.stdout)
    return found


def test_no_broken_input_crashes_hangs_or_takes_much_memory(outcomes: dict[str, Any]) -> None:
    assert {name: outcome["crashes"] for name, outcome in outcomes.items() if outcome["crashes"]} == {}


def test_every_broken_input_is_accepted_or_counted_with_a_reason(outcomes: dict[str, Any]) -> None:
    assert len(outcomes) in (len(SOME), 22)
    for outcome in outcomes.values():
        assert outcome["accepted"] + sum(outcome["refused"].values()) == outcome["inputs"] > 0
    reasons = [reason for outcome in outcomes.values() for reason in outcome["refused"]]
    assert len(reasons) > (50 if len(outcomes) == 22 else 15)


def test_extreme_messages_of_every_type_can_be_made(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(FUZZ.parent)
    extreme, wire = importlib.import_module("fuzzing.extreme"), importlib.import_module("fuzzing.wire")
    of_texts = [kind for kind in wire.KINDS if tuple[str, ...] in dict(kind.scalars).values()]
    assert of_texts
    for kind in of_texts:
        for number in range(150):  # some have longer texts than a message holds
            assert extreme.extreme_token(kind, random.Random(number))


def test_a_crash_is_reported_and_fails_the_script(tmp_path: Path) -> None:
    script = tmp_path / "weak.py"
    script.write_text(
        f"import os, sys\nsys.path.insert(0, {str(FUZZ.parent)!r})\n"
        "import fuzzing.campaign as fuzz\nfrom fuzzing.target import Target\n"
        "def take(number):\n"
        "    if number == 1: raise AssertionError('seen')\n"
        "    if number == 3: os.abort()\n"
        "numbers = iter(range(100))\n"
        "fuzz.target = lambda name: Target(lambda rng: int(fuzz_place[0]), take, ())\n"
        "attack = fuzz.attack\n"
        "def watched(name, seed, first, last, place):\n"
        "    global fuzz_place\n    fuzz_place = place\n    return attack(name, seed, first, last, place)\n"
        "fuzz.attack = watched\n"
        "sys.exit(fuzz.main())\n"
    )
    words = [sys.executable, str(script), "--only", "ring", "--share", "0.0003", "--json"]
    done = subprocess.run(words, capture_output=True, text=True, check=False)
    assert done.returncode == 1, done.stderr
    outcome = json.loads(done.stdout)["ring"]
    assert any("3: the process ended with -6" in crash for crash in outcome["crashes"])
    assert outcome["inputs"] == 6
