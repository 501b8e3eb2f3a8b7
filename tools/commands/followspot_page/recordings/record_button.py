"""The record button: a recorder in its own process, fed by taps at the ports of the run."""

from __future__ import annotations

import asyncio
import importlib.util
import json
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from functools import partial
from itertools import count
from pathlib import Path
from typing import Any

from followspot.errors import FollowspotError
from followspot.graph.output_ports import chosen_ports, output_ports
from followspot.graph.plan import Plan
from followspot.library.handle import RunHandle, Tapping
from followspot.operating_system.child_processes import module_command
from followspot.taps.receivers import tap_key
from followspot_record.firings import firing_types
from followspot_record.order import Order

TAP = "recording.tap"
_BEGINNING, _ENDING = 30.0, 8.0
"""Seconds for a recorder to open its file, and to complete it."""

Publish = Callable[[dict[str, Any]], Any]
"""Receives a recording's state: state (on, over, failed), file, bytes, messages, lost, seconds, error."""


class RecordButton:
    """Starts and stops recordings of a run, one at a time.

    folder: of the page, for sockets; publish: receives the state for browsers.
    """

    def __init__(self, folder: Path, publish: Publish) -> None:
        self._folder = folder
        self._publish = publish
        self._numbers = count()
        self._process: asyncio.subprocess.Process | None = None
        self._report_task: asyncio.Task[None] | None = None
        self._untap: Callable[[], None] = lambda: None
        """Removes the taps of the recording."""

    async def start(self, run: RunHandle, plan: Plan, words: str) -> str:
        """Record the ports that the words name, or all for ""; a line about it.

        Raises FollowspotError.
        """
        if importlib.util.find_spec("mcap") is None:
            raise FollowspotError('recordings need mcap: pip install "followspot[recording]"')
        if self._process is not None:
            raise FollowspotError("it is recorded already")
        ports = chosen_ports(words or None, output_ports(plan), "record", plan.offered)
        names = (*ports, *firing_types(plan, ports))
        metadata = await asyncio.to_thread(run.metadata)
        if metadata.out is None:
            raise FollowspotError("recordings are written on the operator's host; start them there")
        path = metadata.out / time.strftime("recorded-%Y%m%d-%H%M%S.mcap")
        listen = self._folder / f"recorder-{next(self._numbers)}"
        remote = _remote(plan, run.run, names)
        begun = await self._begin(
            Order(plan=plan, ports=names, path=path, listen=listen, remote=remote, network=metadata.network)
        )
        taps = [Tapping(name, TAP, _params(name, None if name in remote else listen)) for name in names]
        await asyncio.to_thread(run.tap, taps)
        self._untap = partial(run.untap, taps)
        self._publish(begun)
        return f"recording {len(ports)} ports to {begun['file']}"

    async def stop(self) -> str:
        """Stop the recording; a line about it. Raises FollowspotError if there is none."""
        if self._process is None:
            raise FollowspotError("nothing is recorded")
        assert self._process.stdin is not None
        self._process.stdin.write(b"stop\n")
        await self.close()
        return "the recording is complete"

    async def close(self) -> None:
        """Wait until the recording is complete, after its run."""
        process, report_task = self._process, self._report_task
        if process is None or report_task is None:
            return
        assert process.stdin is not None
        process.stdin.close()
        with suppress(TimeoutError):
            await asyncio.wait_for(report_task, _ENDING)
        if process.returncode is None:
            process.kill()
        await asyncio.to_thread(self._untap)

    async def _begin(self, order: Order) -> dict[str, Any]:
        """Start the recorder; its first report. Raises FollowspotError."""
        pipe = asyncio.subprocess.PIPE
        command = module_command("followspot_record.recorder_process")
        self._process = await asyncio.create_subprocess_exec(
            *command, stdin=pipe, stdout=pipe, start_new_session=True
        )
        assert self._process.stdin is not None
        self._process.stdin.write(order.model_dump_json().encode() + b"\n")
        said: dict[str, Any] = {"state": "failed", "error": "it does not answer"}
        with suppress(TimeoutError):
            async with asyncio.timeout(_BEGINNING):
                said = await self._said(self._process) or {"state": "failed", "error": "it has ended"}
        if said["state"] == "failed":
            self._process.kill()
            self._process = None
            raise FollowspotError(f"the recorder cannot begin: {said['error']}")
        self._report_task = asyncio.create_task(self._pass_on_reports(self._process))
        return said

    async def _pass_on_reports(self, process: asyncio.subprocess.Process) -> None:
        """Pass on the recorder's reports until it has ended."""
        last: dict[str, Any] = {}
        while (said := await self._said(process)) and said["state"] == "on":
            last = said
            self._publish(said)
        await process.wait()
        self._process = None  # first, because browsers may start another recording once they know
        self._publish(said or {**last, "state": "failed", "error": "the recorder has died"})

    async def _said(self, process: asyncio.subprocess.Process) -> dict[str, Any] | None:
        """The next report of a recorder; None at its end."""
        assert process.stdout is not None
        line = await process.stdout.readline()
        said: dict[str, Any] | None = json.loads(line) if line else None
        return said


def recordable(plan: Plan) -> list[str]:
    """Stages of the graph file with outputs, in its order."""
    sending = {port.rpartition(".")[0] for port in output_ports(plan)}
    return list(dict.fromkeys(stage.group for stage in plan.stages if stage.name in sending))


def _remote(plan: Plan, run: str, names: Sequence[str]) -> dict[str, str]:
    """The ports on other hosts, with the Zenoh keys of their taps."""
    there = {name: plan.host_of_stage(name.rpartition(".")[0]) for name in names}
    return {name: tap_key(run, host, name, TAP) for name, host in there.items() if host}


def _params(name: str, listen: Path | None) -> dict[str, str]:
    return {"port": name, **({"socket": str(listen)} if listen else {})}
