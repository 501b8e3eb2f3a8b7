"""The flight recorder of a run: `python -m followspot_record.flight.process`.

The first line of standard input is a `FlightOrder`, a second one a `FlightEnd`. It finds the run, taps its
ports, takes marks from it, and ends with the run or with its input. Then it prints a line for each file.
"""

from __future__ import annotations

import shutil
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import suppress

from followspot import Message
from followspot.errors import FollowspotError
from followspot.files import unused_path
from followspot.graph.plan import Plan
from followspot.library.handle import NoAnswer, RunHandle, read_log, run_here
from followspot.library.run_taps import RunTaps
from followspot.messages import InvalidMessage
from followspot.plugins.registry import use_plugin_files
from followspot.taps.framing import Record
from followspot.taps.receivers import Gaps
from followspot.wire import header_of
from followspot_record.firings import firing_types
from followspot_record.flight.faults import FaultWatch
from followspot_record.flight.keep_request import kept_types
from followspot_record.flight.moment_file import MomentFile
from followspot_record.flight.order import FlightEnd, FlightOrder
from followspot_record.flight.recorder import FlightRecorder
from followspot_record.flight.watch import ConditionWatch

_TAP = "recording.tap"
_START_POLL_INTERVAL = 0.05
_PERIOD = 0.2
"""Seconds between two exchanges with the run."""
_LOOK = 0.4
"""Seconds between two checks for faults."""
_LEAVING = 3.0
"""Seconds for the last messages of a run to arrive."""
_LEAST_FREE = 1 << 30
_AFTER = 5.0
"""Seconds after a fault or a condition that belong to its moment."""


class FlightProcess:
    """The recorder of one run, and its taps."""

    def __init__(self, run: RunHandle, order: FlightOrder) -> None:
        """Raises FollowspotError."""
        self._run = run
        self._order = order
        plan = self._plan = run.plan()
        out = run.metadata().out
        if out is None:
            raise FollowspotError("what is kept of a run is written on its operator's host; start it there")
        self._out = out
        self._types: dict[str, type[Message]] = {}
        """Of all ports that are or were kept, and of firings."""
        self._keep_ports_of(plan)
        self.recorder = FlightRecorder(order.period, order.limit, self._open_file)
        self._taken = 0
        self._began = time.time_ns()
        self._faults = FaultWatch()
        self._looked = 0.0
        self._conditions = ConditionWatch(order.mark_when, plan, kept_types(plan, order.ports), self._mark)
        self._taps = RunTaps(run, self._types, _TAP, self._consume)

    def watch(self, over: threading.Event) -> None:
        """Keep and mark until the run ends, or `over`."""
        with suppress(FollowspotError):
            while not over.is_set():
                with suppress(NoAnswer):
                    self._exchange()
                    self._check_run()
                self.recorder.finish_files()
                over.wait(_PERIOD)

    def close(self, errors: tuple[str, ...]) -> Iterator[str]:
        """Complete what is marked; a line for each file. errors: of the run, which are a mark as well."""
        self._taps.close(_LEAVING)
        errors = errors or self._logged_errors()
        if errors:
            self._mark(f"the run failed: {errors[0].strip().splitlines()[-1]}", after=0.0)
        self.recorder.close()
        for moment in self.recorder.kept().moments:
            said = moment.problem or f"{moment.seconds:.1f} s of the run, as marked"
            yield f"{moment.file or 'a moment is not saved'}: {said}"

    def _logged_errors(self) -> tuple[str, ...]:
        """The errors in the log of a run of the command line, since it is kept."""
        try:
            records = list(read_log(self._out))
        except FollowspotError:
            return ()
        return tuple(one.text for one in records if one.level == "error" and one.time >= self._began)

    def _exchange(self) -> None:
        for mark in self._run.exchange_marks(self.recorder.kept(), self._taken):
            self.recorder.mark(mark.after, mark.note, mark.number)
            self._taken = mark.number

    def _check_run(self) -> None:
        if time.monotonic() - self._looked < _LOOK:
            return
        self._looked = time.monotonic()
        status = self._run.status()
        for fault in self._faults.new_faults(status):
            self._mark(fault)
        self._conditions.check(status, self._plan)
        plan = self._run.plan()
        if plan.stages != self._plan.stages:
            self._plan = plan
            use_plugin_files(plan.plugin_files)
            self._keep_ports_of(plan)
        self._taps.follow(tuple(self._types))

    def _keep_ports_of(self, plan: Plan) -> None:
        """Keep the ports of a plan, too. Raises FollowspotError."""
        kept = kept_types(plan, self._order.ports)
        self._types |= kept | firing_types(plan, kept)

    def _mark(self, note: str, after: float = _AFTER) -> None:
        """A mark that no user made: it leaves room on the disk for what users record."""
        if shutil.disk_usage(self._out).free < _LEAST_FREE:
            self.recorder.refuse(note, f"less than 1 GiB is free on the disk of {self._out}")
        else:
            self.recorder.mark(after, note)

    def _open_file(self) -> MomentFile:
        with suppress(FollowspotError):  # else the last one, of a run that has just ended
            self._plan = self._run.plan()
        path = unused_path(self._out / time.strftime("moment-%Y%m%d-%H%M%S.mcap"))
        return MomentFile(path, self._plan, self._types, self._order.files, self._order.limit)

    def _consume(self, records: Iterator[Record]) -> None:
        gaps = Gaps()
        with suppress(ValueError, KeyError):  # a malformed stream
            for port, number, packed in records:
                missing = gaps.before(port, number)
                with suppress(InvalidMessage):
                    self.recorder.put(port, header_of(packed).time, missing, packed)
                    self._conditions.take(port, packed)


def _begun(order: FlightOrder, over: threading.Event) -> FlightProcess | None:
    """The recorder of the run as soon as that answers; None if the run is over before.

    Raises FollowspotError if the run cannot be kept.
    """
    while not over.wait(_START_POLL_INTERVAL):
        with suppress(FollowspotError):
            run = run_here(order.run)
            break
    else:
        return None
    try:
        return FlightProcess(run, order)
    except FollowspotError:
        if not _ended(run):
            raise
        over.wait()  # or its operator would take the end of this process for that of a recorder at work
        return None


def _ended(run: RunHandle) -> bool:
    """Whether a run takes no requests any more."""
    try:
        run.status()
    except NoAnswer:
        return False
    except FollowspotError:
        return True
    return False


def main() -> int:
    """Entry of the process."""
    order = FlightOrder.model_validate_json(sys.stdin.readline())
    over = threading.Event()
    ends: list[FlightEnd] = []

    def listen() -> None:
        line = sys.stdin.readline()
        ends.append(FlightEnd.model_validate_json(line) if line.strip() else FlightEnd())
        over.set()

    threading.Thread(target=listen, daemon=True).start()
    try:
        process = _begun(order, over)
    except FollowspotError as error:
        print(f"nothing is kept of the run: {error}", flush=True)
        return 1
    if process is None:
        print("nothing is kept: the run was over before its flight recorder had begun", flush=True)
        return 0
    process.watch(over)
    over.wait(_LEAVING)  # the run's process says how it ended
    for line in process.close(ends[0].errors if ends else ()):
        print(line, flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
