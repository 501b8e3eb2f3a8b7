"""Stages that answer later are swapped, and stopped, without loss."""

from __future__ import annotations

import threading
from pathlib import Path

import pytest
from tests.core.worker.rates import live

from followspot.errors import FollowspotError
from followspot.operator.change.hot_swap import change_stages
from followspot.operator.run_requests import ChangeStages
from followspot.worker.runners import deferred_runner


def test_a_stage_that_answers_later_is_swapped_and_loses_nothing(tmp_path: Path) -> None:
    run = live(
        tmp_path,
        "  sensor: {uses: rates.device, with: {hz: 300, count: 1000000}, depth: 10000}\n"
        "  later: {uses: rates.later, in: {reading: sensor}, with: {longest_ms: 20}, concurrency: 4}\n"
        "  save: {uses: rates.note, in: {reading: later}}\n",
    )
    begun = threading.Event()
    problems: list[BaseException] = []

    def meddle() -> None:
        try:
            assert begun.wait(60)
            change_stages(run, ChangeStages(words=("later.longest_ms=5",)))
            with pytest.raises(FollowspotError, match="in another way"):
                change_stages(run, ChangeStages(words=("later=rates.burst",)))
        except BaseException as error:
            problems.append(error)
        finally:
            run.stop()

    meddler = threading.Thread(target=meddle)
    meddler.start()
    report = run.execute(lambda progress, _: begun.set() if progress.fired > 10 else None)
    meddler.join()
    assert not problems, problems
    assert report.ok, report.errors
    assert run.plan.notes == ("while it ran: later: longest_ms = 5",)
    lines = (tmp_path / "readings.csv").read_text().splitlines()
    values = [int(line.split()[1]) for line in lines]
    assert values == [n + 1 for n in range(values[-1]) if n % 5], (
        "each in order, and every fifth says nothing"
    )


def test_a_stopped_run_ends_though_answers_never_come(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(deferred_runner, "_ANSWER_TIMEOUT", 0.05)
    run = live(
        tmp_path,
        "  sensor: {uses: rates.device, with: {count: 1000000}}\n"
        "  silent: {uses: rates.silent, in: {reading: sensor}, concurrency: 2}\n"
        "  save: {uses: rates.note, in: {reading: silent}}\n"
        "  seen: {uses: rates.note, in: {reading: sensor}, with: {path: seen.csv}}\n",
    )
    report = run.execute(lambda progress, _: run.stop() if progress.time > 0 else None)
    assert report.ok, report.errors
    assert sum("did not come within" in text for text in report.warnings) >= 2
