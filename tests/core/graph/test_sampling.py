"""Inputs that are sampled in a cycle without a delay: a replay refuses them, a live run says so."""

from __future__ import annotations

from pathlib import Path

import pytest

from followspot.errors import InputError, Mistake
from followspot.graph.compile import compile_graph
from followspot.graph.plan import Plan
from followspot.worker.wiring import Wiring

ROOT = Path(__file__).parents[3]
TICKS = ROOT / "tests" / "stages" / "ticks.py"
LOOP = """
graph: loop
seed: 1
stages:
  count: {{uses: {source}}}
  sum:   {{uses: ticks.accumulate, in: {{number: count, before: {before}}}}}
  later: {{uses: ticks.accumulate, in: {{number: sum, before: {again}}}}}
  save:  {{uses: ticks.write, in: {{number: later}}}}
"""
DELAYED = "{from: later, delay: 1}"


def planned(
    folder: Path, source: str = "ticks.count", before: str = "later", again: str = DELAYED, *overrides: str
) -> Plan:
    file = folder / "loop.yaml"
    file.write_text(LOOP.format(source=source, before=before, again=again))
    return compile_graph(file, plugin_files=[TICKS], overrides=overrides)


def refused(*arguments: object) -> tuple[Mistake, ...]:
    with pytest.raises(InputError) as caught:
        planned(*arguments)  # type: ignore[arg-type]
    return caught.value.mistakes


def place(mistake: Mistake) -> tuple[str, int, int]:
    assert mistake.place is not None
    return Path(mistake.place.file).name, mistake.place.line, mistake.place.column


def test_a_replay_refuses_a_sampled_cycle_at_its_edge_and_names_cycle_and_remedy(tmp_path: Path) -> None:
    (mistake,) = refused(tmp_path)
    assert place(mistake) == ("loop.yaml", 6, 63)
    assert 'input "before" of stage "sum" samples "later"' in mistake.text
    assert "in the cycle later -> sum -> later, which has no delay" in mistake.text
    assert mistake.remedy == "delay it: {from: later, delay: 1}"
    assert planned(tmp_path, "ticks.count", "{from: later, delay: 1}").notes == ()


def test_the_whole_demo_without_delays_has_a_mistake_for_each_edge(tmp_path: Path) -> None:
    text = (ROOT / "graphs" / "glowballs.yaml").read_text()
    sampled = text.replace("{from: track.forecast, delay: 1}", "track.forecast")
    (tmp_path / "g.yaml").write_text(sampled)
    with pytest.raises(InputError) as caught:
        compile_graph(tmp_path / "g.yaml", room=ROOT / "graphs" / "rooms" / "simulated.yaml")
    lines = [mistake.place.line for mistake in caught.value.mistakes if mistake.place]
    expected = [
        n
        for n, line in enumerate(sampled.splitlines(), 1)
        if "in: {" in line and "forecast: track.forecast" in line
    ]
    assert lines == expected
    assert len(lines) == 7
    assert all(m.remedy == "delay it: {from: track.forecast, delay: 1}" for m in caught.value.mistakes)


def test_a_stage_that_samples_itself_is_refused(tmp_path: Path) -> None:
    (mistake,) = refused(tmp_path, "ticks.count", DELAYED, "later")
    assert "in the cycle later -> later" in mistake.text


@pytest.mark.parametrize(
    ("before", "override", "where"),
    [
        (DELAYED, "sum.in.before=later", ("--set", 1, 15)),
        (DELAYED, "sum.in.before.delay=0", ("loop.yaml", 6, 70)),
        ("{from: count}", "sum.in.before.from=later.out", ("--set", 1, 20)),
    ],
)
def test_overrides_are_refused_where_they_stand(
    tmp_path: Path, before: str, override: str, where: tuple[str, int, int]
) -> None:
    (mistake,) = refused(tmp_path, "ticks.count", before, DELAYED, override)
    assert place(mistake) == where


def test_an_extended_file_is_refused_at_its_own_place(tmp_path: Path) -> None:
    planned(tmp_path, "ticks.live")
    (tmp_path / "loop.yaml").rename(tmp_path / "part.yaml")
    whole = tmp_path / "whole.yaml"
    whole.write_text("graph: whole\nextends: part.yaml\n")
    with pytest.raises(InputError) as caught:
        compile_graph(whole, plugin_files=[TICKS], overrides=["count.uses=ticks.count"])
    (mistake,) = caught.value.mistakes
    assert place(mistake) == ("part.yaml", 6, 63)


def test_the_remedy_removes_a_policy_that_no_delayed_edge_may_have(tmp_path: Path) -> None:
    (mistake,) = refused(tmp_path, "ticks.count", "{from: later, policy: latest}")
    assert mistake.remedy == "delay it: {from: later, delay: 1} without policy: latest"


def test_a_live_run_says_that_its_result_depends_on_timing(tmp_path: Path) -> None:
    (note,) = planned(tmp_path, "ticks.live").notes
    assert note.startswith(f"{tmp_path / 'loop.yaml'}:6:63: the result depends on timing: ")
    assert "later -> sum -> later" in note
    assert note.endswith("{from: later, delay: 1}")


def test_a_graph_that_may_be_live_is_not_refused_before_its_source_is_known(tmp_path: Path) -> None:
    (mistake,) = refused(tmp_path, "ticks.lively")
    assert "ticks.lively" in mistake.text


def test_a_delay_elsewhere_in_the_cycle_is_enough(tmp_path: Path) -> None:
    (tmp_path / "g.yaml").write_text(
        "graph: g\nstages:\n"
        "  count: {uses: ticks.count}\n"
        "  a: {uses: ticks.accumulate, in: {number: count, before: b}}\n"
        "  b: {uses: ticks.accumulate, in: {number: count, before: {from: a, delay: 1}}}\n"
    )
    plan = compile_graph(tmp_path / "g.yaml", plugin_files=[TICKS])
    wiring = Wiring(plan)
    assert [stage.name for stage in plan.stages] == ["count", "b", "a"], "what is sampled runs first"
    assert all(wiring.timed(edge) for edge in plan.edges if edge.to_port == "before")


def test_a_plan_that_comes_by_another_way_is_refused_by_its_workers(tmp_path: Path) -> None:
    live = planned(tmp_path, "ticks.live")
    frozen = Plan(
        live.graph,
        live.room,
        tuple(
            type(s)(s.name, s.group, s.uses.replace("live", "count"), {}, None, s.worker, False)
            for s in live.stages
        ),
        live.edges,
        live.workers,
    )
    with pytest.raises(InputError, match="later -> sum -> later"):
        Wiring(frozen)


def test_thousands_of_sampled_cycles_are_refused_in_a_moment_and_counted(tmp_path: Path) -> None:
    count = 400
    lines = [
        f"  s{n}: {{uses: ticks.swapped, in: {{number: s{n - 1}, before: s{count - 1}}}}}"
        for n in range(1, count)
    ]
    text = "graph: g\nstages:\n  s0: {uses: ticks.count}\n" + "\n".join(lines)
    (tmp_path / "g.yaml").write_text(text)
    with pytest.raises(InputError) as caught:
        compile_graph(tmp_path / "g.yaml", plugin_files=[TICKS])
    named = [m for m in caught.value.mistakes if "in the cycle" in m.text]
    assert f"{count - 1 - len(named)} more inputs are sampled in cycles" in str(caught.value)
