"""The request guard: admits each fresh, valid request of an operator once."""

from __future__ import annotations

import json
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from followspot.security.request_guard import (
    FORMAT,
    MAX_REMEMBERED,
    MAX_REQUEST,
    WINDOW,
    Asked,
    Rejected,
    RequestGuard,
    envelope,
)

HERE = "pc-left"
DESK = Asked(HERE, "stop", "operator", "desk")


def request(**changes: Any) -> bytes:
    fields = {
        "format": FORMAT,
        "id": "0123456789abcdef",
        "time": 1000.0,
        "asked": DESK,
        "data": {"run": "a"},
    }
    return json.dumps(fields | changes).encode()


def guard(now: float = 1000.0) -> RequestGuard:
    return RequestGuard(HERE, {"stop", "status"}, clock=lambda: now)


def test_a_fresh_request_of_an_operator_is_admitted() -> None:
    assert RequestGuard(HERE, {"stop"}).admit(DESK, envelope(DESK, {"run": "a"})) == {"run": "a"}


def test_a_replayed_request_is_rejected_and_another_one_admitted() -> None:
    gate = guard()
    gate.admit(DESK, request())
    with pytest.raises(Rejected) as refused:
        gate.admit(DESK, request())
    assert refused.value.reason == "replayed"
    gate.admit(DESK, request(id="f" * 16))


def test_a_request_is_remembered_for_as_long_as_it_is_fresh() -> None:
    now = 1000.0
    gate = RequestGuard(HERE, {"stop"}, clock=lambda: now, steady=lambda: now)
    sent = now + WINDOW
    gate.admit(DESK, request(time=sent))
    now = sent + WINDOW
    with pytest.raises(Rejected) as refused:
        gate.admit(DESK, request(time=sent))
    assert refused.value.reason == "replayed"
    now += 0.001
    with pytest.raises(Rejected) as refused:
        gate.admit(DESK, request(time=sent))
    assert refused.value.reason == "stale"


@pytest.mark.parametrize("sent", [1000 - WINDOW - 1, 1000 + WINDOW + 1])
def test_an_old_request_and_one_from_the_future_are_refused_with_the_remedy(sent: float) -> None:
    with pytest.raises(Rejected, match="set the clocks") as refused:
        guard().admit(DESK, request(time=sent))
    assert refused.value.reason == "stale"


@pytest.mark.parametrize("step", [-86_400.0, 1000.0])
def test_an_operator_goes_on_although_the_clock_of_the_host_is_set(
    step: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    true, set_by = 1e9, 0.0
    monkeypatch.setattr("followspot.security.request_guard.time.time", lambda: true)
    gate = RequestGuard(HERE, {"stop"}, clock=lambda: true + set_by, steady=lambda: true - 9e8)
    old = envelope(DESK, {"run": "a"})
    gate.admit(DESK, old)
    set_by = step
    for _ in range(3):
        true += 100.0
        gate.admit(DESK, envelope(DESK, {"run": "a"}))
    with pytest.raises(Rejected, match="old by the clock here"):
        gate.admit(DESK, old)


def test_a_clock_that_was_wrong_before_the_first_request_counts_no_more(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    true, wrong_by = 1e9, -3600.0
    monkeypatch.setattr("followspot.security.request_guard.time.time", lambda: true)
    gate = RequestGuard(HERE, {"stop"}, clock=lambda: true + wrong_by, steady=lambda: true)
    captured = envelope(DESK, {"run": "a"})
    with pytest.raises(Rejected):
        gate.admit(DESK, captured)
    wrong_by = 0.0
    gate.admit(DESK, envelope(DESK, {"run": "a"}))
    true += 3600.0
    with pytest.raises(Rejected, match="old by the clock here"):
        gate.admit(DESK, captured)


@pytest.mark.parametrize("role", ["camera", "worker", "router", "", "Operator"])
def test_other_roles_may_ask_nothing(role: str) -> None:
    with pytest.raises(Rejected, match="may not stop") as refused:
        guard().admit(Asked(HERE, "stop", role, "pc-right"), request())
    assert refused.value.reason == "role"


def test_a_rejected_request_does_not_use_up_its_id() -> None:
    gate = guard()
    with pytest.raises(Rejected):
        gate.admit(Asked(HERE, "stop", "camera", "pc-right"), request())
    gate.admit(DESK, request())


@pytest.mark.parametrize(
    ("reason", "payload"),
    [
        ("size", b" " * (MAX_REQUEST + 1)),
        ("form", b""),
        ("form", b"\xff\xfe"),
        ("form", b"[]"),
        ("form", b"[" * 200_000),
        ("form", b"1" * 10_000),
        ("version", b"{}"),
        ("version", request(format=FORMAT - 1)),
        ("form", request(id="short")),
        ("form", request(id="x" * 65)),
        ("form", request(id=["0123456789abcdef"])),
        ("form", request(data=[])),
        ("form", request(time="1000")),
        ("form", request(time=True)),
        ("form", request(time=float("nan"))),
        ("form", request(time=float("inf"))),
        ("form", request(time=10**400)),
        ("form", request(asked=None)),
        ("form", request(asked="pc-left")),
        ("form", request(asked=[["pc-left"], "stop", "operator", "desk"])),
    ],
)
def test_an_invalid_request_is_rejected_with_its_reason(reason: str, payload: bytes) -> None:
    with pytest.raises(Rejected) as refused:
        guard().admit(DESK, payload)
    assert refused.value.reason == reason


@given(
    st.dictionaries(
        st.sampled_from(["format", "id", "time", "asked", "data"]), st.none() | st.integers() | st.text()
    )
)
def test_any_bytes_are_admitted_or_rejected(changes: dict[str, Any]) -> None:
    gate = guard()
    try:
        assert isinstance(gate.admit(DESK, request(**changes)), dict)
    except Rejected as refused:
        gate.count("somebody", refused)
    assert sum(gate.refused.values()) <= 1


@pytest.mark.parametrize(
    "written",
    [
        DESK._replace(agent="pc-right"),
        DESK._replace(verb="status"),
        DESK._replace(role="camera"),
        DESK._replace(name="second"),
        DESK[:3],
        (*DESK, "more"),
        (),
    ],
)
def test_a_request_with_another_agent_verb_or_sender_is_rejected(
    written: tuple[str, ...],
) -> None:
    gate = guard()
    with pytest.raises(Rejected) as refused:
        gate.admit(DESK, request(asked=written))
    assert refused.value.reason == "address"
    gate.admit(DESK, request())


def test_a_wildcard_key_is_rejected() -> None:
    everybody = DESK._replace(agent="*")
    with pytest.raises(Rejected) as refused:
        guard().admit(everybody, envelope(everybody, {"run": "a"}))
    assert refused.value.reason == "address"


def test_an_unknown_verb_is_refused_with_the_known_ones() -> None:
    with pytest.raises(Rejected, match="known: status, stop"):
        guard().admit(DESK._replace(verb="erase"), request())


def test_a_flood_of_requests_takes_bounded_memory_and_ends_with_the_window() -> None:
    now = 1000.0
    gate = RequestGuard(HERE, {"stop"}, clock=lambda: now, steady=lambda: now)
    for number in range(MAX_REMEMBERED):
        gate.admit(DESK, request(id=f"{number:016}"))
    with pytest.raises(Rejected) as refused:
        gate.admit(DESK, request(id="f" * 16))
    assert refused.value.reason == "flood"
    now += 2 * WINDOW
    gate.admit(DESK, request(id="f" * 16, time=now))


def test_rejections_are_counted_by_reason_and_their_log_is_limited() -> None:
    lines: list[str] = []
    gate = RequestGuard(HERE, {"stop"}, lines.append)
    for _ in range(1000):
        gate.count("followspot/agent/a/stop/camera/pc-left", Rejected("role", "may not"))
    assert gate.refused == {"role": 1000}
    assert "pc-left" in lines[0]
    assert len(lines) == 30


def test_a_key_has_agent_verb_role_and_name() -> None:
    assert Asked.of("followspot/agent/pc-left/stop/operator/desk") == DESK
    with pytest.raises(Rejected):
        Asked.of("stop")
