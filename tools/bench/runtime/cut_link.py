"""What a cut link costs an edge over Zenoh, as it is and with the retransmission of zenoh-ext.

    python tools/bench/runtime/cut_link.py
    python tools/bench/runtime/cut_link.py --cuts 0.5 2 10 --json

Two hosts, network namespaces on this machine, so root is needed: one sends pictures of 320 x 240 (230 kB) at
60 a second, the link goes down for some seconds and comes back, the other notes what arrives. `plain`
publishes as the edges of followspot do; `cache` is the AdvancedPublisher of zenoh-ext, which keeps the last
pictures, with a subscriber that asks for what it missed.

Missed are pictures that never came. Back is the time from the return of the link until a picture came that
was sent after it. Late are those that came after the link and were over 100 ms old; age is that of
the oldest. Processor time is that of the sender for a picture.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import time
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import zenoh
import zenoh.ext

from benching.hosts_cases import PICTURE, Hosts
from followspot.transport.zenoh.network import Network
from followspot.transport.zenoh.session import connected
from followspot.transport.zenoh.terms import has_subscriber, publisher
from scripting import shown, table_options

KEY = "followspot/bench/cut"
RATE = 60.0
BEFORE, AFTER = 2.0, 6.0
"""Seconds of the stream before the cut, and after the link is back."""
BEGUN = "begun"
_LONGEST = 20.0
"""Seconds in which both sides must have found each other."""
_DRAIN = 2.0
"""Seconds after the last picture in which what was late may still come."""
HEARTBEAT_MS = 100
LATE_MS = 100.0
Figures = dict[str, float]


def main() -> None:
    """Cut in turns, or be one of the two processes."""
    args = parser().parse_args()
    if args.side:
        order = json.loads(args.order)
        print(json.dumps(send(order) if args.side == "send" else receive(order)))
        return
    rows = []
    with TemporaryDirectory() as made, Hosts(Path(made), ["desk", "left"]) as hosts:
        for seconds in args.cuts:
            for cached in (0, args.cache):
                rows.append((seconds, cached, cut(hosts, seconds, cached)))
                print(rows[-1], file=sys.stderr)
    found = [{"cut_s": seconds, "cached": cached, **figures} for seconds, cached, figures in rows]
    print(json.dumps(found) if args.json else text(args, found))


def parser() -> argparse.ArgumentParser:
    """The command line."""
    options = table_options(__doc__)
    options.add_argument(
        "--cuts", nargs="+", type=float, default=[0.5, 2.0, 5.0], help="seconds without link"
    )
    options.add_argument("--cache", type=int, default=60, help="pictures that the sender keeps (60)")
    options.add_argument("--side", choices=("send", "receive"), help=argparse.SUPPRESS)
    options.add_argument("--order", help=argparse.SUPPRESS)
    return options


def cut(hosts: Hosts, seconds: float, cached: int) -> Figures:
    """One cut."""
    total = BEFORE + seconds + AFTER
    order = json.dumps({"cached": cached, "seconds": total, "at": hosts.endpoint("left")})
    receiver, sender = (
        _process(hosts, host, side, order) for host, side in (("desk", "receive"), ("left", "send"))
    )
    assert sender.stdout is not None
    if sender.stdout.readline().strip() != BEGUN:
        raise SystemExit("the sender did not begin")
    time.sleep(BEFORE)
    hosts.link("left", "down")
    down = time.monotonic_ns()
    time.sleep(seconds)
    hosts.link("left", "up")
    up = time.monotonic_ns()
    sent = json.loads(sender.communicate()[0])
    arrived = json.loads(receiver.communicate()[0])
    return figures(sent, arrived, down, up)


def _process(hosts: Hosts, host: str, side: str, order: str) -> subprocess.Popen[str]:
    words = [
        "ip",
        "netns",
        "exec",
        hosts.space(host),
        sys.executable,
        __file__,
        "--side",
        side,
        "--order",
        order,
    ]
    return subprocess.Popen(words, stdout=subprocess.PIPE, text=True)


def send(order: dict[str, Any]) -> dict[str, Any]:
    """Pictures at the rate; when each was sent, ns, and the processor time of one, us."""
    session = connected(Network((order["at"],), insecure=True))
    try:
        plain = publisher(session, KEY)
        by: Any = plain
        if order["cached"]:  # the stubs ask for options of the other kind as well
            by = zenoh.ext.declare_advanced_publisher(
                session,
                KEY,
                congestion_control=zenoh.CongestionControl.BLOCK,
                express=True,
                cache=zenoh.ext.CacheConfig(max_samples=order["cached"]),
                sample_miss_detection=zenoh.ext.MissDetectionConfig(heartbeat=HEARTBEAT_MS),  # type: ignore[call-arg]
            )
        deadline = time.monotonic() + _LONGEST
        while not has_subscriber(plain) and time.monotonic() < deadline:
            time.sleep(0.05)
        print(BEGUN, flush=True)
        return _paced(by, round(order["seconds"] * RATE))
    finally:
        session.close()  # type: ignore[no-untyped-call]


def _paced(by: Any, count: int) -> dict[str, Any]:
    sent, body, begun, worked = [], bytes(PICTURE), time.monotonic(), time.process_time()
    for number in range(count):
        time.sleep(max(0.0, begun + number / RATE - time.monotonic()))
        sent.append(time.monotonic_ns())
        by.put(number.to_bytes(8, "little") + body)
    return {"sent": sent, "cpu_us": (time.process_time() - worked) * 1e6 / count}


def receive(order: dict[str, Any]) -> list[tuple[int, int]]:
    """The number of each picture that came, and when, ns."""
    session = connected(Network(("tcp/127.0.0.1:0",), (order["at"],), insecure=True))
    arrived: list[tuple[int, int]] = []

    def take(sample: zenoh.Sample) -> None:
        arrived.append((int.from_bytes(sample.payload.to_bytes()[:8], "little"), time.monotonic_ns()))

    try:
        declared: Any
        if order["cached"]:
            recovery = zenoh.ext.RecoveryConfig(heartbeat=True)  # type: ignore[call-arg]
            declared = zenoh.ext.declare_advanced_subscriber(session, KEY, take, recovery=recovery)
        else:
            declared = session.declare_subscriber(KEY, take)
        begun, ended = time.monotonic() + _LONGEST, order["seconds"] + _DRAIN
        while time.monotonic() < (arrived[0][1] / 1e9 + ended if arrived else begun):
            time.sleep(0.1)
        declared.undeclare()
    finally:
        session.close()  # type: ignore[no-untyped-call]
    return arrived


def figures(sent: dict[str, Any], arrived: list[tuple[int, int]], down: int, up: int) -> Figures:
    """Of one cut. down, up: when the link went and came, ns."""
    times = sent["sent"]
    ages = [(came, (came - times[number]) / 1e6) for number, came in arrived]
    new = [came for number, came in arrived if times[number] >= up]
    late = [age for came, age in ages if came >= up and age > LATE_MS]
    usual = sorted(age for came, age in ages if came < down)
    return {
        "sent": len(times),
        "missed": len(times) - len({number for number, _ in arrived}),
        "back_s": (min(new) - up) / 1e9 if new else float("nan"),
        "late": len(late),
        "oldest_s": max(late, default=0.0) / 1e3,
        "p50_ms": usual[len(usual) // 2] if usual else float("nan"),
        "cpu_us": sent["cpu_us"],
    }


def text(args: argparse.Namespace, rows: list[dict[str, float]]) -> str:
    """The table."""
    cells = [
        (
            f"{row['cut_s']:g} s, " + (f"cache of {row['cached']}" if row["cached"] else "plain"),
            *(f"{row['sent']:.0f}", f"{row['missed']:.0f}", f"{row['back_s']:.1f}", f"{row['late']:.0f}"),
            *(f"{row['oldest_s']:.1f}", f"{row['p50_ms']:.1f}", f"{row['cpu_us']:.0f}"),
        )
        for row in rows
    ]
    heads = ("cut", "sent", "missed", "back, s", "late", "age, s", "p50 before, ms", "CPU, us")
    return shown(args, heads, cells)


if __name__ == "__main__":
    main()
