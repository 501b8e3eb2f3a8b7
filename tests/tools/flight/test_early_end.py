"""A run that ends before its flight recorder has begun."""

from __future__ import annotations

import json
import os
import socket
import subprocess
import threading

from followspot.operating_system.child_processes import module_command
from followspot_record.flight.order import FlightEnd, FlightOrder

RUN = "0123456789abcdef"


def test_a_run_that_ends_while_its_recorder_begins_is_told_as_such() -> None:
    """The run is in sight, and gone when it is asked for its plan."""
    with socket.socket(socket.AF_UNIX) as run:
        run.bind(f"\0followspot-{os.getuid()}-{os.getpid()}-{RUN}")
        run.listen()

        def describe_and_end() -> None:
            client, _ = run.accept()
            with client, client.makefile("rw") as lines:
                lines.readline()
                run.close()
                about = {"run": RUN, "graph": "short", "pid": os.getpid()}
                lines.write(json.dumps({"answer": about}) + "\n")

        ending = threading.Thread(target=describe_and_end)
        ending.start()
        process = subprocess.Popen(
            module_command("followspot_record.flight.process"),
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        assert process.stdin is not None
        process.stdin.write(FlightOrder(run=RUN, period=1.0, limit=1 << 20).model_dump_json() + "\n")
        process.stdin.flush()
        ending.join()
        said, _ = process.communicate(FlightEnd().model_dump_json() + "\n", timeout=60.0)
    assert said == "nothing is kept: the run was over before its flight recorder had begun\n"
    assert process.returncode == 0


def test_a_run_that_is_over_before_it_is_found_is_told_alike() -> None:
    order = FlightOrder(run="fedcba9876543210", period=1.0, limit=1 << 20).model_dump_json()
    done = subprocess.run(
        module_command("followspot_record.flight.process"),
        input=f"{order}\n{FlightEnd().model_dump_json()}\n",
        stdout=subprocess.PIPE,
        text=True,
        check=True,
    )
    assert done.stdout == "nothing is kept: the run was over before its flight recorder had begun\n"
