"""Stages that give several messages for one, and stages that answer later."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from concurrent.futures import Future
from pathlib import Path
from typing import Any, ClassVar

import pytest
from tests.core.worker.bench import Bench, Note
from tests.core.worker.solo import Solo

from followspot import Deferred, Outputs, Stage, at
from followspot.graph.compile import compile_graph
from followspot.messages import Header, stamped
from followspot.ports.signature import ports
from followspot.transport.token import END
from followspot.worker.runners import deferred_runner
from followspot.worker.runners.deferred_runner import DeferredRunner
from followspot.worker.runners.error_policy import StageError
from followspot.worker.runners.outputs_runner import MAX_OUTPUTS, OutputsRunner

STAGES = Path(__file__).parents[2] / "stages" / "rates.py"


class Asked(Stage):
    """Answers when it is told to."""

    def setup(self) -> None:
        self.answers: list[Future[Note | None]] = []
        self.closed = False

    def process(self, note: Note) -> Deferred[Note]:
        self.answers.append(Future())
        return self.answers[-1]

    def close(self) -> None:
        self.closed = True


class Several(Stage):
    """Gives what it is told to."""

    gives: ClassVar[Callable[[Note], Any]] = lambda note: ()

    def process(self, note: Note) -> Outputs[Note]:
        return type(self).gives(note)  # type: ignore[no-any-return]


class Asking(Bench):
    def __init__(self, concurrency: int = 3, **options: Any) -> None:
        super().__init__(DeferredRunner, Asked(), **options)
        assert isinstance(self.runner, DeferredRunner)
        self.runner.concurrency = concurrency

    def answer(self, number: int, value: int) -> None:
        assert isinstance(self.stage, Asked)
        self.stage.answers[number].set_result(Note(value))
        self.runner.step()


def test_answers_are_sent_in_the_order_of_the_firings_with_their_times() -> None:
    bench = Asking()
    bench.put(10, 20, 30)
    bench.answer(1, 200)
    bench.answer(2, 300)
    assert bench.got() == []
    bench.answer(0, 100)
    assert bench.got() == [(10, 100), (20, 200), (30, 300)]
    assert [m.header for m in bench.out.messages] == [Header("a", t, t, 5) for t in (10, 20, 30)]


def test_no_more_answers_are_under_way_than_the_graph_says() -> None:
    bench = Asking(concurrency=2)
    bench.put(10, 20, 30, 40)
    assert len(bench.stage.answers) == 2  # type: ignore[attr-defined]
    bench.answer(0, 1)
    assert len(bench.stage.answers) == 3  # type: ignore[attr-defined]
    assert len(bench.into.messages) == 1


def test_nothing_is_asked_while_the_next_edge_is_full() -> None:
    bench = Asking(depth=1)
    bench.put(10, 20)
    bench.answer(0, 1)
    bench.answer(1, 2)
    assert bench.runner.blocked
    bench.put(30)
    assert len(bench.stage.answers) == 2  # type: ignore[attr-defined]
    bench.out.take()
    bench.runner.step()
    assert bench.got() == [(20, 2)]


def test_the_watermark_and_the_end_wait_for_the_answers() -> None:
    bench = Asking()
    bench.put(10, 20)
    bench.into.advance(50)
    bench.runner.step()
    assert bench.out.watermark <= 10
    bench.answer(0, 1)
    assert bench.out.watermark == 11
    bench.end()
    assert (bench.runner.done, bench.stage.closed) == (False, False)  # type: ignore[attr-defined]
    bench.answer(1, 2)
    assert (bench.runner.done, bench.stage.closed) == (True, True)  # type: ignore[attr-defined]
    assert bench.out.watermark == END


def test_an_answer_that_fails_names_its_message_or_is_skipped_and_counted() -> None:
    failing = Asking()
    failing.put(10, 20)
    failing.stage.answers[1].set_result(Note(2))  # type: ignore[attr-defined]
    failing.stage.answers[0].set_exception(OSError("the service is away"))  # type: ignore[attr-defined]
    with pytest.raises(StageError, match=r"asked failed at a#10.*the service is away"):
        failing.runner.step()
    skipping = Asking(on_error="skip")
    skipping.put(10, 20)
    skipping.stage.answers[0].set_exception(OSError("the service is away"))  # type: ignore[attr-defined]
    skipping.answer(1, 2)
    assert skipping.got() == [(20, 2)]
    assert (skipping.runner.count.fired, skipping.runner.count.skipped) == (2, 1)


def test_a_stage_that_was_replaced_is_closed_after_its_last_answer() -> None:
    bench = Asking()
    bench.put(10, 20)
    old, new = bench.stage, Asked()
    new.setup()
    bench.runner.replace_stage(new, lambda: new)
    bench.runner.retire(old)
    bench.put(30)
    new.answers[0].set_result(Note(3))
    bench.answer(0, 1)
    assert not old.closed  # type: ignore[attr-defined]
    bench.answer(1, 2)
    assert old.closed  # type: ignore[attr-defined]
    assert bench.got() == [(10, 1), (20, 2), (30, 3)]
    assert not new.closed


def test_a_stop_gives_up_answers_that_do_not_come(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(deferred_runner, "_ANSWER_TIMEOUT", 0.0)
    bench = Asking()
    bench.put(10, 20)
    bench.stage.answers[1].set_result(Note(2))  # type: ignore[attr-defined]
    bench.runner.limit_wait()  # type: ignore[attr-defined]
    assert bench.runner.overdue_at is not None, "it wakes the worker"
    bench.end()
    assert bench.runner.done
    assert bench.got() == [(20, 2)]
    assert bench.runner.count.skipped == 1
    assert bench.stage.answers[0].cancelled()  # type: ignore[attr-defined]


def test_closing_cancels_what_is_under_way() -> None:
    bench = Asking()
    bench.put(10)
    bench.runner.close()
    assert bench.stage.answers[0].cancelled()  # type: ignore[attr-defined]


def test_functions_are_called_in_as_many_threads_as_the_graph_says(tmp_path: Path) -> None:
    (tmp_path / "g.yaml").write_text(
        "graph: g\nstages:\n  a: {uses: rates.sensor, with: {count: 8}}\n"
        "  b: {uses: rates.crowd, in: {reading: a}, concurrency: 4}\n"
        "  c: {uses: rates.note, in: {reading: b}}\n"
    )
    report = Solo(compile_graph(tmp_path / "g.yaml", plugin_files=[STAGES]), tmp_path).run()
    assert report.ok, report.errors
    lines = (tmp_path / "readings.csv").read_text().splitlines()
    assert [int(line.split()[1]) for line in lines] == list(range(8))


def giving(gives: Callable[[Note], Any], **options: Any) -> Bench:
    return Bench(OutputsRunner, type("Giving", (Several,), {"gives": staticmethod(gives)})(), **options)


def test_several_messages_have_times_of_their_own_and_wait_for_room() -> None:
    bench = giving(lambda note: (note, at(note.value + 3, Note(1)), at(note.value + 5, Note(2))), depth=1)
    bench.put(10)
    assert (bench.got(), bench.runner.blocked) == ([(10, 10)], True)
    bench.put(20)
    assert len(bench.into.messages) == 1, "the next firing waits until all is sent"
    for expected in ((13, 1), (15, 2), (20, 20)):
        bench.out.take()
        bench.runner.step()
        assert bench.got() == [expected]
    assert bench.out.messages[0].header == Header("a", 20, 20, 5)


def test_a_firing_without_messages_advances_the_watermark() -> None:
    bench = giving(lambda note: ())
    bench.put(10)
    assert (bench.got(), bench.out.watermark) == ([], 11)
    bench.end()
    assert bench.runner.done


def _raises(note: Note) -> Iterator[Note]:
    yield at(note.value, Note(1))
    raise OSError("the file ends early")


def _endless(note: Note) -> Iterator[Note]:
    while True:
        yield at(note.value, Note(1))


@pytest.mark.parametrize(
    ("gives", "why", "sent"),
    [
        (lambda note: (at(9, note),), "times rise", 0),
        (lambda note: (note, Note(2)), "write at", 1),
        (lambda note: (at(30, note), at(30, note)), "times rise", 1),
        (lambda note: (None,), "gave nothing", 0),
        (lambda note: (3,), "gave an int, declared Note", 0),
        (lambda note: note, "instead of several messages", 0),
        (_raises, "the file ends early", 0),
        (_endless, f"more than {MAX_OUTPUTS} messages", 0),
    ],
)
def test_what_is_wrong_with_several_messages_is_said(
    gives: Callable[[Note], Any], why: str, sent: int
) -> None:
    with pytest.raises(StageError, match=f"(?s)a#10.*{why}"):
        giving(gives).put(10)
    skipping = giving(gives, on_error="skip")
    skipping.put(10)
    assert (len(skipping.got()), skipping.runner.count.skipped) == (sent, 1)


def test_a_later_firing_must_not_reach_back_before_an_earlier_one() -> None:
    bench = giving(lambda note: (at(note.value + 15, note),), on_error="skip")
    bench.put(10)
    bench.into.put(stamped(Note(-5), Header("a", 20, 20, 5)))
    bench.runner.step()
    assert (len(bench.got()), bench.runner.count.skipped) == (1, 1)


def test_the_marks_of_results_are_read_and_a_state_is_refused() -> None:
    assert (ports(Several).gives, ports(Asked).gives) == ("several", "later")
    assert [port.type for port in (*ports(Several).outputs, *ports(Asked).outputs)] == [Note, Note]

    class Remembers(Asked):
        """Keeps something."""

        def state(self) -> int:
            return 1

    with pytest.raises(Exception, match=r"answers later and defines state\(\)"):
        ports(Remembers)


def test_concurrency_is_for_stages_that_answer_later(tmp_path: Path) -> None:
    (tmp_path / "g.yaml").write_text(
        "graph: g\nstages:\n  a: {uses: rates.sensor}\n"
        "  b: {uses: rates.burst, in: {reading: a}, concurrency: 2}\n"
    )
    with pytest.raises(Exception, match="answers at once and has no concurrency"):
        compile_graph(tmp_path / "g.yaml", plugin_files=[STAGES])


def test_the_last_answer_takes_along_what_is_known_by_then_and_the_others_do_not() -> None:
    bench = Asking(concurrency=2)
    bench.put(0, 10)
    bench.into.advance(50)
    bench.stage.answers[0].set_result(Note(0))
    bench.runner.step()
    assert (len(bench.out.messages), bench.out.watermark) == (1, 1)
    bench.stage.answers[1].set_result(Note(1))
    bench.runner.step()
    assert (len(bench.out.messages), bench.out.watermark) == (2, 50)
