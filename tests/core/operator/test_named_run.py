"""The run that a word means, among those of this machine and those under agents."""

from __future__ import annotations

import pytest

from followspot.errors import FollowspotError
from followspot.operator.attach import FoundRun, _listing
from followspot.operator.named_run import chosen_run
from followspot.operator.run_handle import RunHandle

ENDED = FoundRun("aaaa1111", "show", ("left",), over=True)
GOING = FoundRun("bbbb2222", "show", ("left", "right"), over=False)
LAST = FoundRun("cccc3333", "rehearsal", ("right",), over=True)
ALL = [ENDED, GOING, LAST]


@pytest.mark.parametrize(
    ("wanted", "run"), [("show", GOING), ("aaaa", ENDED), ("rehearsal", LAST), (None, GOING)]
)
def test_a_run_that_goes_on_is_meant_before_one_that_has_ended(wanted: str | None, run: FoundRun) -> None:
    assert chosen_run(_listing([], ALL, wanted), wanted, "in reach") is run


def test_each_run_is_listed_once() -> None:
    here = RunHandle("bbbb2222", "show", lambda request, timeout: None, pid=7)
    listed = r"runs in reach: show \(bbbb2222\), show \(aaaa1111\), rehearsal \(cccc3333\)$"
    with pytest.raises(FollowspotError, match=f"there is no run opera; {listed}"):
        chosen_run(_listing([here], ALL, "opera"), "opera", "in reach")


def test_several_runs_are_named() -> None:
    runs = [GOING, FoundRun("dddd4444", "show", ("left",), over=False)]
    with pytest.raises(FollowspotError, match=r"several runs: show \(bbbb2222\), show \(dddd4444\)"):
        chosen_run(_listing([], runs, "show"), "show", "in reach")
