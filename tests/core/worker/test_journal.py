"""The journal of a stage: with it and the messages, the stage is repeated from every checkpoint on."""

from __future__ import annotations

import json
from collections import defaultdict
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from tests.core.worker.solo import Solo

from followspot import Message
from followspot.graph.compile import compile_graph
from followspot.graph.output_ports import output_ports
from followspot.graph.plan import Plan
from followspot.library.repeat import (
    Repetition,
    Unrepeatable,
    checkpoint_in,
    held_in,
    missing_in,
)
from followspot.message_checks.sealing import seal
from followspot.messages import identical, stamped
from followspot.ports.firing import Firing

RATES = Path(__file__).parents[2] / "stages" / "rates.py"
MEMORIES = """
class Sum(Stage):
    total, weight = 0, 0.1

    def process(self, reading: Reading, last: Latest[Reading]) -> Reading:
        self.total += reading.value + (0 if last is None else last.value % 7)
        self.weight = 1 / (1 + self.weight)
        return type(reading)(self.total + int(1e15 * self.weight) % 1000)

    def state(self):
        return {"total": self.total, "weight": self.weight}

    def restore(self, state):
        self.total, self.weight = state["total"], state["weight"]

class Dice(Stage):
    def process(self, reading: Reading) -> Reading:
        return type(reading)(reading.value + int(self.rng.integers(1000)))

class Behind(Stage):
    def setup(self):
        self.kept = deque()

    def process(self, reading: Reading) -> Lagged[Reading]:
        self.kept.append((reading.header.time, reading.value))
        if len(self.kept) > 4:
            time, value = self.kept.popleft()
            yield at(time, type(reading)(10 * value))

    def state(self):
        return list(self.kept)

    def restore(self, state):
        self.kept = deque(map(tuple, state))

class Partial(Dice):
    state_lacks = "its pictures"

    def state(self):
        return {}

class Secret(Dice):
    def state(self):
        return {1, 2}
"""
GRAPH = """\
graph: kinds
stages:
  frame:  {uses: kinds.sensor, with: {hz: 30, count: 90}}
  fast:   {uses: kinds.sensor, with: {hz: 200, count: 600, shift: 0.0013}}
  slow:   {uses: kinds.sensor, with: {hz: 0.5, count: 2}}
  total:  {uses: kinds.sum, in: {reading: frame, last: {from: mix, delay: 2}}}
  burst:  {uses: kinds.burst, in: {reading: total}}
  mix:
    uses: kinds.mix
    tolerance: 0.003
    in: {frame: total, other: fast, window: fast, near: fast, latest: slow}
  all:    {uses: kinds.together, in: {readings: [frame, total]}}
  dice:   {uses: kinds.dice, in: {reading: mix}}
  behind: {uses: kinds.behind, in: {reading: mix}}
  later:  {uses: kinds.later, in: {reading: frame}, concurrency: 3}
  secret: {uses: kinds.secret, in: {reading: frame}}
  partial: {uses: kinds.partial, in: {reading: frame}}
  write:  {uses: kinds.write, in: {readings: all}}
"""


class Run:
    """What a run sent, by port, and the firings of its stages."""

    def __init__(self, folder: Path) -> None:
        plugins = [folder / "kinds.py"]
        plugins[0].write_text(RATES.read_text() + MEMORIES)
        (folder / "kinds.yaml").write_text(GRAPH)
        self.plan: Plan = compile_graph(folder / "kinds.yaml", plugin_files=plugins)
        self.types = output_ports(self.plan)
        self.before: dict[tuple[str, int], dict[str, int]] = {}
        """Number of messages of each port that were sent before a firing, by stage and row."""
        solo = Solo(self.plan, folder)
        self.sent: Mapping[str, list[Message]] = defaultdict(list)
        self.firings: Mapping[str, list[Firing]] = defaultdict(list)
        for runner in solo.scheduler.runners:
            for port, output in runner.outputs:
                output.tap(self.sent[f"{runner.name}.{port}"].append)
            runner.journal.tap(partial(self.fire, runner.name))
        assert solo.run().ok

    def fire(self, name: str, firing: Message) -> None:
        assert isinstance(firing, Firing)
        row = len(self.firings[name])
        self.before[name, row] = {port: len(messages) for port, messages in self.sent.items()}
        self.firings[name].append(firing)

    def repeated(self, name: str, begin: int, out: Path) -> Sequence[Message]:
        """What a stage sends if its firings are repeated from the one of this row on.

        Of what was sent before, it has what the checkpoint contains.
        """
        found: list[Message] = []
        checkpoint = checkpoint_in(self.firings[name][begin])
        assert checkpoint is not None
        stage = next(stage for stage in self.plan.stages if stage.name == name)
        again = Repetition(
            self.plan, stage, checkpoint, out, self.types, lambda output, message: found.append(message)
        )
        known = dict(held_in(checkpoint, self.types))
        for port, messages in self.sent.items():
            later = messages[self.before[name, begin].get(port, 0) :]
            known |= {(port, message.header.time): message for message in later}
        for firing in self.firings[name][begin:]:
            again.repeat(firing, lambda port, time: known[port, time])
        again.close()
        return found


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Run:
    return Run(tmp_path_factory.mktemp("run"))


def checkpoints(firings: Sequence[Firing]) -> list[int]:
    return [row for row, firing in enumerate(firings) if len(firing.checkpoint)]


@pytest.mark.parametrize("name", ["total", "burst", "mix", "all", "dice", "behind", "later"])
def test_a_stage_repeats_from_each_checkpoint_what_it_sent(run: Run, name: str, tmp_path: Path) -> None:
    rows = checkpoints(run.firings[name])
    assert len(rows) == 3, "one for each second"
    for row in rows:
        again = run.repeated(name, row, tmp_path)
        before = run.sent[f"{name}.out"]
        assert len(again) >= 10
        assert len(again) < len(before) or row == 0
        expected = before[len(before) - len(again) :]
        assert all(identical(a, b) for a, b in zip(expected, again, strict=True)), (name, row)


def test_each_firing_says_what_it_took(run: Run) -> None:
    newest: Sequence[tuple[str, int]] = ()
    for number, firing in enumerate(run.firings["mix"]):
        checkpoint = checkpoint_in(firing)
        newest = newest if checkpoint is None else checkpoint.edges
        assert firing.header.seq == number
        taken = [(newest[row][0], time) for row, time in zip(firing.edge, firing.captured, strict=True)]
        now = firing.header.time
        assert [abs(time - now) <= 3_000_000 for port, time in taken if port == "total.out"] == [True]
        window = [time for port, time in taken if port == "fast.out" and time <= now]
        assert len(window) >= 6 or number == 0
        assert [time for port, time in taken if port == "slow.out"] == [now // 2_000_000_000 * 2_000_000_000]


def test_a_checkpoint_has_what_a_sampled_input_holds_for_long(run: Run) -> None:
    row = checkpoints(run.firings["mix"])[1]
    checkpoint = checkpoint_in(run.firings["mix"][row])
    assert checkpoint is not None
    held = dict(held_in(checkpoint, run.types))
    assert identical(held["slow.out", 0], run.sent["slow.out"][0])


def test_a_message_that_is_missing_is_named(run: Run) -> None:
    firing = run.firings["total"][0]
    checkpoint = checkpoint_in(firing)
    assert checkpoint is not None
    assert list(missing_in(firing, checkpoint, lambda port, time: False)) == ["frame.out"]
    assert not list(missing_in(firing, checkpoint, lambda port, time: True))


def test_a_state_that_cannot_be_saved_is_named(run: Run, tmp_path: Path) -> None:
    with pytest.raises(Unrepeatable, match="TypeError: a set"):
        run.repeated("secret", 0, tmp_path)


def test_a_stage_whose_state_leaves_something_out_repeats_from_its_first_firing_only(
    run: Run, tmp_path: Path
) -> None:
    again, expected = run.repeated("partial", 0, tmp_path), run.sent["partial.out"]
    assert all(identical(a, b) for a, b in zip(expected, again, strict=True))
    with pytest.raises(Unrepeatable, match="was not saved: it leaves out its pictures"):
        run.repeated("partial", checkpoints(run.firings["partial"])[1], tmp_path)


@pytest.mark.parametrize(
    ("field", "value", "problem"),
    [
        ("edges", [["total.out", 99]], "an edge leads to no input"),
        ("edges", [["total.out", -1]], "an edge leads to no input"),
        ("inputs", [], "an edge leads to no input"),
        ("inputs", [{"role": "sampled", "joined": False}] * 6, "6 inputs"),
        ("inputs", [{"role": "sampled", "joined": False}] * 5, "no message that lets the stage fire"),
        ("uses", "kinds.dice", "5 inputs"),
        ("held", [[5000, ""]], "damaged"),
        ("state", {"\0array": "AAAA", "dtype": "O", "shape": [1]}, "an array of object"),
        ("random", {"bit_generator": "PCG64"}, "cannot be restored"),
    ],
)
def test_a_damaged_checkpoint_is_named(
    run: Run, tmp_path: Path, field: str, value: object, problem: str
) -> None:
    row = checkpoints(run.firings["mix"])[1]
    whole = run.firings["mix"][row]
    data = {**json.loads(whole.checkpoint.tobytes()), field: value}
    text = np.frombuffer(json.dumps(data).encode(), "u1")
    torn = seal(Firing(checkpoint=text, edge=whole.edge, captured=whole.captured))
    run.firings["mix"][row] = stamped(torn, whole.header)
    try:
        with pytest.raises(Unrepeatable, match=problem):
            run.repeated("mix", row, tmp_path)
    finally:
        run.firings["mix"][row] = whole


def test_a_stage_that_is_not_tapped_notes_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refused(*_: object) -> None:
        raise AssertionError("it costs time")

    path = tmp_path / "g.yaml"
    path.write_text(
        "graph: g\nstages:\n  a: {uses: rates.sensor, with: {count: 3}}\n"
        "  b: {uses: rates.note, in: {reading: a}}\n"
    )
    solo = Solo(compile_graph(path, plugin_files=[RATES]), tmp_path)
    monkeypatch.setattr("followspot.worker.journal.Journal.before", refused)
    assert solo.run().ok
