"""The settings of a flight recorder, from options and scripts."""

from __future__ import annotations

import argparse
import importlib.util
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from types import MappingProxyType

from followspot.errors import InputError
from followspot.graph.output_ports import chosen_ports, output_ports
from followspot.graph.plan import Plan
from followspot.library.keep_options import Keep, bytes_of, seconds_of
from followspot.messages import Message
from followspot.plugins.registry import OFFERED
from followspot_record.flight.order import FlightOrder
from followspot_record.flight.running_recorder import running_recorder
from followspot_record.flight.watch import ConditionWatch
from followspot_record.record import graph_files


def keep_of(args: argparse.Namespace) -> Keep:
    """The request that the options make. Raises InputError."""
    if args.keep is None:
        raise InputError.of("--keep-ports, --keep-memory and --mark-when need --keep", "--keep 30s")
    if getattr(args, "detach", False):
        raise InputError.of("--keep needs an operator that stays", "run without --detach")
    ports = tuple(args.keep_ports.split(",")) if args.keep_ports else ()
    found = Keep(seconds_of(args.keep, "--keep"), ports, mark_when=tuple(args.mark_when))
    if args.keep_memory:
        found = replace(found, memory=bytes_of(args.keep_memory, "--keep-memory"))
    return found


def check_options(plan: Plan, args: argparse.Namespace) -> None:
    """Raises InputError if the plan cannot be kept as the options say."""
    check(plan, keep_of(args))


def check(plan: Plan, keep: Keep) -> None:
    """Raises InputError if the plan cannot be kept so."""
    if importlib.util.find_spec("mcap") is None:
        raise InputError.of("recordings need mcap", 'pip install "followspot[recording]"')
    if own := [stage.name for stage in plan.stages if stage.uses.startswith(OFFERED)]:
        raise InputError.of(
            f"{', '.join(own)}: a flight recorder is another process, which cannot load a class of this one",
            "put it into a file, and name that with plugin_files",
        )
    ConditionWatch(keep.mark_when, plan, kept_types(plan, keep.ports))


def kept_types(plan: Plan, words: Sequence[str]) -> dict[str, type[Message]]:
    """The ports that are kept, with the types of their messages; all without words. Raises InputError."""
    known = output_ports(plan)
    chosen = chosen_ports(",".join(words) or None, known, "--keep-ports", plan.offered)
    return {port: known[port] for port in chosen}


def order_of(args: argparse.Namespace) -> FlightOrder:
    """The order for the run of this process that the options ask for."""
    return _order(keep_of(args), str(os.getpid()), graph_files(args))


@contextmanager
def kept_run(keep: Keep, run: str) -> Iterator[Callable[[Sequence[str]], None]]:
    """Keep a run of this name; yields what takes its errors."""
    with running_recorder(_order(keep, run)) as recorder:
        yield recorder.failed


def _order(keep: Keep, run: str, files: Mapping[str, str] = MappingProxyType({})) -> FlightOrder:
    return FlightOrder(
        run=run,
        period=keep.seconds,
        limit=keep.memory,
        ports=keep.ports,
        mark_when=keep.mark_when,
        files=dict(files),
    )
