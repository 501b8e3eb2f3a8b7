"""Clocks of hosts as `followspot top` shows them."""

from __future__ import annotations

from followspot_watch.top import text


def test_the_clock_of_each_host_is_shown_and_one_that_is_off_is_named() -> None:
    def clock(host: str, offset: float, exchanges: int = 16) -> dict[str, object]:
        times = {"offset_ms": offset, "round_trip_ms": 0.4, "exchanges": exchanges}
        return {"host": host, "reference": "pc-left", **times}

    clocks = [clock("", 0.2), clock("pc-right", -30.0), clock("pc-top", 0.0, 0)]
    empty = {
        "fired": 0,
        "expected": None,
        "rate": 0.0,
        "stages": [],
        "edges": [],
        "paths": [],
        "news": [],
        "faults": [],
        "change_awaits": "",
    }
    lines = text({"graph": "g", "run": "0123456789", **empty, "clocks": clocks}).splitlines()
    (desk,) = (line.split() for line in lines if "this host" in line)
    assert desk == ["this", "host", "pc-left", "+0.200", "0.400"]
    assert any("pc-right" in line and "-30.000" in line and "set it by NTP" in line for line in lines)
    assert any("pc-top" in line and "not compared" in line for line in lines)
