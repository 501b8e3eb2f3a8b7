"""The benchmarks run, and their rooms are what their tables say."""

from __future__ import annotations

import json
import os
import sys
from pathlib import Path

import numpy as np
import pytest
import yaml

from bench.recording import recorded_bytes, replay
from bench.runtime import cut_link, edges, forecast_delay, hop, hop_code, scaling, start
from benching.processes import family, memory
from followspot.graph.compile import compile_graph
from followspot.room_file import load, save

EDGE_CASES = [
    *[(edges.BARE, "1 kB"), ("ring one copy", "1 kB")],
    *[(edges.BARE, "640x480"), ("ring in place", "640x480"), (edges.SHARED, "640x480")],
]


def test_the_cost_table_runs_for_its_smallest_room(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    size = "--cameras 2 --frames 3 --warm-up 2 --rounds 1 --json"
    monkeypatch.setattr(sys, "argv", ["scaling.py", *size.split()])
    scaling.main()
    (row,) = json.loads(capsys.readouterr().out)
    assert row["case"] == {"cameras": 2, "targets": 6, "size": [320, 240]}
    assert {"color", "infrared", "verify", "triangulate", "fuse", "track"} <= set(row["stages_ms"])
    assert sum(row["stages_ms"].values()) > 0
    assert row["searching_ms"] > 0


def test_rooms_of_the_cost_table_are_valid_and_have_the_size_they_say(tmp_path: Path) -> None:
    case = scaling.Case(cameras=24, targets=24, size=(1280, 720))
    save(scaling.room_of(case, frames=10), tmp_path / "room.yaml")
    room = load(tmp_path / "room.yaml")
    assert (len(room.cameras), len(room.targets)) == (24, 24)
    assert all(camera.size == (1280, 720) for camera in room.cameras.values())
    centers = np.array([camera.center for camera in room.cameras.values()])
    apart = np.linalg.norm(centers[:, None] - centers, axis=2) + np.eye(24)
    assert apart.min() > 0.1


def test_the_room_of_the_long_replay_is_valid_and_small(tmp_path: Path) -> None:
    (tmp_path / "room.yaml").write_text(yaml.safe_dump(replay.small_room(frames=40)))
    room = load(tmp_path / "room.yaml")
    assert {name: camera.size for name, camera in room.cameras.items()} == {
        "cam0": (160, 120),
        "cam1": (160, 120),
        "cam2": (160, 120),
    }
    assert all(camera.source.params["frames"] == 40 for camera in room.cameras.values() if camera.source)


def test_the_costs_of_hops_and_edges_are_measured(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(
        sys, "argv", ["hop.py", *["--hops", "2", "--messages", "20", "--rounds", "1", "--json"]]
    )
    hop.main()
    assert set(json.loads(capsys.readouterr().out)) == {"hop_us", "call_us", "ratio"}
    measured = {(edge, size): edges.measure(edge, size, messages=5) for edge, size in EDGE_CASES}
    for found in edges.summary([measured]):
        assert 0 < found.round.p50_us <= found.round.p99_us
        assert min(found.round) > 0
        assert found.edge != edges.BARE or found.ratio == (1, 1, 1, 1)


def test_a_hop_over_iceoryx2_is_measured() -> None:
    pytest.importorskip("iceoryx2", reason="iceoryx2 is not installed")
    found = edges.measure(edges.ICEORYX, "640x480", messages=5)
    assert 0 < found.p50_us <= found.p99_us
    assert min(found) > 0


def test_every_way_to_store_pictures_gives_the_same_bits_and_rows_take_fewest_bytes_of_noise() -> None:
    found = recorded_bytes.measure(recorded_bytes.noisy(4), rounds=1)
    shares = {name: row["share"] for name, row in found.items()}
    assert shares["rows, zstd"] < 0.6 < shares["zstd alone"] < shares["lz4"] + 0.01


def test_the_code_of_a_hop_is_counted_without_valgrind(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(sys, "argv", ["hop_code.py", "--messages", "5", "--rounds", "1", "--json"])
    monkeypatch.setenv("PATH", "")
    hop_code.main()
    rows = json.loads(capsys.readouterr().out)
    calls = {(row["size"], row["case"]): row["python_calls"] for row in rows}
    assert len(calls) == len(hop_code.SIZES) * len(hop_code.CASES)
    for size in hop_code.SIZES:
        assert calls[size, "system calls"] == 0
        assert calls[size, "bare ring"] < calls[size, "ring"]
    assert {row["instructions"] for row in rows} == {None}


def test_overlays_with_a_longer_delay_delay_the_forecast_of_detectors_alone(tmp_path: Path) -> None:
    plan = compile_graph(forecast_delay.overlay(tmp_path, 2))
    delays = {e.to_stage.split("/")[0]: e.delay for e in plan.edges if e.from_port == "forecast"}
    assert delays.pop("color") == delays.pop("infrared") == 2
    assert set(delays.values()) == {1}


def test_what_a_cut_link_costs_is_told_from_when_pictures_were_sent_and_came() -> None:
    second = 10**9
    sent = {"sent": [n * second for n in range(8)], "cpu_us": 7.0}
    came = {0: 0.01, 1: 1.01, 3: 6.0, 6: 6.01, 7: 7.01}
    arrived = [(number, round(at * second)) for number, at in came.items()]
    found = cut_link.figures(sent, arrived, down=1_500_000_000, up=5_500_000_000)
    assert found == {
        **{"sent": 8, "missed": 3, "back_s": 0.51, "late": 1, "oldest_s": 3.0},
        **{"p50_ms": 10.0, "cpu_us": 7.0},
    }


def test_memory_of_a_session_is_told_by_process_and_by_kind_of_process() -> None:
    found = memory(os.getsid(0))
    own = found[os.getpid()]
    assert own.resident >= own.shared_out >= own.own > 0
    assert family(os.getsid(0))[os.getpid()] == os.getppid()
    parents = {20: 10, 30: 20, 31: 20}
    assert [start.kind(pid, 10, parents, forked=True) for pid in (10, 20, 30)] == [
        "command",
        "fork server",
        "worker",
    ]
    assert start.kind(20, 10, parents, forked=False) == "worker"
