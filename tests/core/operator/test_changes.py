"""Hot swaps and moves over several workers and hosts: all take over, or none does."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import pytest

from followspot.control.host import HostLost, HostStatus, WorkerPhase, WorkerStatus
from followspot.control.move import MoveOrder
from followspot.control.observation import GetStates
from followspot.control.swap import ChangeOrder, ChangePhase, ChangeStatus
from followspot.errors import FollowspotError
from followspot.graph.change.move import plan_after_move
from followspot.graph.change.stages import Change
from followspot.graph.compile import compile_graph
from followspot.graph.plan import Plan, PlannedStage
from followspot.graph.plan_data import plan_from_data
from followspot.host.hot_swap import HostChange
from followspot.operator.change.hot_swap import change_hosts
from followspot.operator.change.move import move_hosts
from followspot.operator.change_under_way import OnWait

TICKS = Path(__file__).parents[2] / "stages" / "ticks.py"
GRAPH = """
graph: g
stages:
  a: {uses: ticks.live}
  b: {uses: ticks.tally, in: {number: a}}
  c: {uses: ticks.tally, in: {number: a}}
"""


def planned(folder: Path, left: str, right: str) -> Plan:
    """A plan with the stages b and c in two workers on these hosts."""
    (folder / "g.yaml").write_text(GRAPH)
    workers = f"  left: {{{left}stages: [b]}}\n  right: {{{right}stages: [c]}}\n"
    (folder / "p.yaml").write_text(f"placement: p\nworkers:\n{workers}")
    return compile_graph(folder / "g.yaml", placement=folder / "p.yaml", plugin_files=[TICKS])


def swapped(plan: Plan) -> tuple[PlannedStage, ...]:
    return tuple(replace(s, params={**s.params, "step": 7}) for s in plan.stages if s.name != "a")


def test_a_worker_that_dies_during_take_over_restarts_with_its_replacements(tmp_path: Path) -> None:
    plan = planned(tmp_path, "", "")
    change = HostChange(ChangeOrder(id="1", step="take_over", stages=swapped(plan)), plan)
    assert change.take_answer("left", ChangeStatus("1", "done"))
    assert change.status().phase == "building"
    assert change.died("right")
    assert change.status() == ChangeStatus("1", "done")
    assert not change.died("right"), "once"
    assert not change.died("left"), "it had answered"


def test_a_worker_that_dies_before_the_take_over_fails_the_change(tmp_path: Path) -> None:
    plan = planned(tmp_path, "", "")
    change = HostChange(ChangeOrder(id="1", step="build", stages=swapped(plan)), plan)
    change.take_answer("left", ChangeStatus("1", "built"))
    assert not change.died("right")
    assert change.status() == ChangeStatus("1", "failed", "worker right has ended")


@dataclass
class Place:
    """A host that does each step at once, except for the step that it refuses.

    silent: how often it does not answer when it is told to take over.
    """

    name: str
    refuses: str = ""
    silent: int = 0
    steps: list[float] = field(default_factory=lambda: [1])
    """Values of the parameter `step` of its stage, newest last."""
    change_status: ChangeStatus = ChangeStatus()

    def ask(self, order: ChangeOrder) -> None:
        if order.step == "take_over" and self.silent:
            self.silent -= 1
            raise HostLost(f"host {self.name} does not answer")
        if order.step == self.refuses:
            self.change_status = ChangeStatus(order.id, "failed", f"{self.name} cannot", order.turn)
            return
        if order.step == "take_over":
            self.steps += [stage.params["step"] for stage in order.stages]
        phase: ChangePhase = "built" if order.step == "build" else "done"
        self.change_status = ChangeStatus(order.id, phase, turn=order.turn)

    def status(self) -> HostStatus:
        return HostStatus((WorkerStatus("w", "running"),), (), change=self.change_status)


def changed(plan: Plan, places: Sequence[Place]) -> None:
    change_hosts(plan, places, Change(swapped(plan), {}, plan.subgraphs), fresh=False)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("refused", "left", "right"), [("", [1, 7], [1, 7]), ("build", [1], [1]), ("take_over", [1, 7, 1], [1])]
)
def test_if_one_host_fails_all_keep_their_old_stages(
    tmp_path: Path, refused: str, left: list[int], right: list[int]
) -> None:
    plan = planned(tmp_path, "host: pc-left, ", "host: pc-right, ")
    places = [Place("pc-left"), Place("pc-right", refused)]
    if refused:
        with pytest.raises(FollowspotError, match="pc-right cannot"):
            changed(plan, places)
    else:
        changed(plan, places)
    assert [place.steps for place in places] == [left, right]


def test_a_host_that_does_not_answer_takes_over_later_for_others_have_done_so(tmp_path: Path) -> None:
    plan = planned(tmp_path, "host: pc-left, ", "host: pc-right, ")
    places = [Place("pc-left"), Place("pc-right", silent=3)]
    changed(plan, places)
    assert [place.steps for place in places] == [[1, 7], [1, 7]]


def test_a_step_that_a_host_is_told_again_is_the_same_step(tmp_path: Path) -> None:
    """The answer to the first order was lost on its way."""
    order = ChangeOrder(id="1", step="take_over", stages=(), turn=4)
    change = HostChange(order)
    assert change.repeats(order)
    for other in ({"id": "2"}, {"turn": 5}, {"step": "go_on"}):
        assert not change.repeats(order.model_copy(update=other))
    assert not HostChange().repeats(order)


def kind_of(order: MoveOrder | GetStates) -> str:
    if isinstance(order, GetStates):
        return "states"
    return "trial" if order.trial else "leaving" if order.plan is None else "plan"


class WorkerPool:
    """A host whose workers leave and start at once, except for one that cannot start."""

    def __init__(
        self,
        name: str,
        plan: Plan,
        *,
        refuses: bool = False,
        unable: str = "",
        silent_from: str = "",
        returns: bool = True,
    ) -> None:
        """silent_from: kind of the first order that finds the host silent; it answers again at a way back,
        unless not `returns`."""
        self.returns = returns
        self.name = name
        self.silent_from, self.silent = silent_from, False
        self.later: list[MoveOrder] = []
        """Orders to be done when it answers."""
        self.refuses = refuses
        self.unable = unable
        self.began: list[str] = []
        """Restarted workers, in order."""
        self.workers = {w.name: WorkerStatus(w.name, "running") for w in plan.workers if w.host == name}

    def ask(self, order: MoveOrder | GetStates) -> object:
        self.silent |= self.silent_from == kind_of(order)
        if self.silent and isinstance(order, MoveOrder) and order.back:
            self.later.append(order)
            return {}
        if self.silent:
            raise HostLost(f"host {self.name} does not answer")
        if isinstance(order, MoveOrder):
            self._move(order)
        return {}

    def _move(self, order: MoveOrder) -> None:
        if order.trial and self.refuses:
            raise FollowspotError(f"{self.name} has no such file")
        if order.trial:
            return
        for name in set(order.leaving) & set(self.workers):
            self.workers[name] = replace(self.workers[name], phase="absent")
        if order.plan is not None:
            self._take_places(plan_from_data(order.plan))

    def _take_places(self, plan: Plan) -> None:
        mine = [worker.name for worker in plan.workers if worker.host == self.name]
        there = {name: worker for name, worker in self.workers.items() if name in mine}
        for name in mine:
            if name not in there or there[name].phase == "absent":
                self.began.append(name)
                stages = [stage.name for stage in plan.stages if stage.worker == name]
                phase: WorkerPhase = "absent" if self.unable in stages else "running"
                there[name] = WorkerStatus(name, phase, restarts=len(self.began))
        self.workers = there

    def status(self) -> HostStatus:
        if self.silent and self.returns and len(self.later) == 2:
            self.silent, self.silent_from = False, ""
            for order in self.later:
                self._move(order)
        absent = [name for name in self.began if self.workers[name].phase == "absent"]
        news = (
            "stage a failed before the move",
            *(f"stage of {name} failed: no space\nat line 1" for name in absent),
        )
        age = 60.0 if self.silent else 0.0
        return HostStatus(tuple(self.workers.values()), (), news=news, age_s=age)


def test_a_host_refuses_a_stage_before_any_worker_leaves(tmp_path: Path) -> None:
    plan = planned(tmp_path, "host: pc-left, ", "host: pc-right, ")
    pools = [WorkerPool("", plan), WorkerPool("pc-left", plan), WorkerPool("pc-right", plan, refuses=True)]
    with pytest.raises(FollowspotError, match="pc-right has no such file"):
        move_hosts(plan, plan_after_move(plan, ["b"], "pc-right"), pools)  # type: ignore[arg-type]
    assert [pool.began for pool in pools] == [[], [], []]


def test_a_stage_that_cannot_begin_at_its_new_place_goes_back_to_its_old_one(tmp_path: Path) -> None:
    plan = planned(tmp_path, "host: pc-left, ", "host: pc-right, ")
    pools = [WorkerPool("", plan), WorkerPool("pc-left", plan), WorkerPool("pc-right", plan, unable="b")]
    why = r"worker right cannot begin at its new place\n    pc-right: stage of right failed: no space$"
    with pytest.raises(FollowspotError, match=why):
        move_hosts(plan, plan_after_move(plan, ["b"], "pc-right"), pools)  # type: ignore[arg-type]
    assert [pool.began for pool in pools] == [["main", "main"], ["left"], ["right", "right"]]
    assert {worker.phase for pool in pools for worker in pool.workers.values()} == {"running"}


@pytest.mark.parametrize("silent_from", ["leaving", "states", "plan"])
def test_a_host_that_falls_silent_during_a_move_keeps_no_worker_from_going_back(
    tmp_path: Path, silent_from: str
) -> None:
    plan = planned(tmp_path, "host: pc-left, ", "host: pc-right, ")
    silent = WorkerPool("pc-right", plan, silent_from=silent_from)
    pools = [WorkerPool("", plan), WorkerPool("pc-left", plan), silent]
    with pytest.raises(FollowspotError, match="host pc-right does not answer"):
        move_hosts(plan, plan_after_move(plan, ["b"], "pc-right"), pools)  # type: ignore[arg-type]
    assert {worker.phase for pool in pools for worker in pool.workers.values()} == {"running"}
    assert [pool.began[-1:] for pool in pools] == [["main"], ["left"], ["right"]]


def test_a_command_that_gives_up_waiting_for_a_silent_host_says_who_undoes_the_move(tmp_path: Path) -> None:
    plan = planned(tmp_path, "host: pc-left, ", "host: pc-right, ")
    silent = WorkerPool("pc-right", plan, silent_from="plan", returns=False)
    pools = [WorkerPool("", plan), WorkerPool("pc-left", plan), silent]
    there = r"host pc-right does not answer: what ran there begins again at its old place within 60 s"
    with pytest.raises(FollowspotError, match=rf"on the way back: interrupted\n    {there}"):
        move_hosts(
            plan,
            plan_after_move(plan, ["b"], "pc-right"),
            pools,  # type: ignore[arg-type]
            interrupt("worker right to begin at its old place"),
        )
    assert [pool.began[-1:] for pool in pools] == [["main"], ["left"], []]


def test_a_move_says_what_it_waits_for(tmp_path: Path) -> None:
    plan = planned(tmp_path, "host: pc-left, ", "host: pc-right, ")
    pools = [WorkerPool("", plan), WorkerPool("pc-left", plan), WorkerPool("pc-right", plan)]
    said: list[str] = []
    move_hosts(plan, plan_after_move(plan, ["b"], "pc-right"), pools, said.append)  # type: ignore[arg-type]
    hosts = ("this host", "host pc-left", "host pc-right")
    steps = ("check the new plan", "stop its workers", "give the states of its stages")
    assert said == [
        *(f"{host} to {step}" for step in steps for host in hosts),
        *(f"{host} to take the new plan" for host in ("host pc-right", "this host", "host pc-left")),
    ]


def test_a_change_names_the_hosts_that_it_waits_for(tmp_path: Path) -> None:
    plan = planned(tmp_path, "host: pc-left, ", "host: pc-right, ")
    said: list[str] = []
    places = [Place("pc-left"), Place("pc-right", "build")]
    wanted = Change(swapped(plan), {}, plan.subgraphs)
    with pytest.raises(FollowspotError, match="pc-right cannot"):
        change_hosts(plan, places, wanted, fresh=False, on_wait=said.append)  # type: ignore[arg-type]
    assert said[:2] == ["host pc-left to build the new stages", "host pc-right to build the new stages"]
    assert "host pc-left to close the new stages" in said


def interrupt(at: str) -> OnWait:
    """The user presses Ctrl-C when the change waits for this."""
    pressed: list[str] = []

    def on_wait(what: str) -> None:
        if what == at and not pressed:
            pressed.append(what)
            raise KeyboardInterrupt

    return on_wait


@pytest.mark.parametrize(
    "at", ["host pc-right to stop its workers", "this host to give the states of its stages"]
)
def test_ctrl_c_during_a_move_brings_all_workers_back(tmp_path: Path, at: str) -> None:
    plan = planned(tmp_path, "host: pc-left, ", "host: pc-right, ")
    pools = [WorkerPool("", plan), WorkerPool("pc-left", plan), WorkerPool("pc-right", plan)]
    with pytest.raises(KeyboardInterrupt):
        move_hosts(plan, plan_after_move(plan, ["b"], "pc-right"), pools, interrupt(at))  # type: ignore[arg-type]
    assert {worker.phase for pool in pools for worker in pool.workers.values()} == {"running"}
    assert [pool.began for pool in pools] == [["main"], ["left"], ["right"]]


@pytest.mark.parametrize(
    ("at", "left", "right"),
    [
        ("host pc-right to build the new stages", [1], [1]),
        ("host pc-right to let the new stages take over", [1, 7, 1], [1, 1]),
    ],
)
def test_ctrl_c_during_a_swap_keeps_the_old_stages(
    tmp_path: Path, at: str, left: list[int], right: list[int]
) -> None:
    plan = planned(tmp_path, "host: pc-left, ", "host: pc-right, ")
    places = [Place("pc-left"), Place("pc-right")]
    wanted = Change(swapped(plan), {}, plan.subgraphs)
    with pytest.raises(KeyboardInterrupt):
        change_hosts(plan, places, wanted, fresh=False, on_wait=interrupt(at))  # type: ignore[arg-type]
    assert [place.steps for place in places] == [left, right]
