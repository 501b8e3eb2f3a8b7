"""The life of one stage instance: it is built, set up, built again after errors, and closed."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from followspot.graph.plan import ErrorPolicy
from followspot.message_checks.outputs import WrongOutput, check_returned
from followspot.messages import Header
from followspot.ports.signature import ports
from followspot.stage import Stage
from followspot.worker.runners.error_policy import RAISED, StageError, recover, text_of
from followspot.worker.runners.forked_copy import NO_COPIES, set_up
from followspot.worker.runners.runner_count import RunnerCount
from followspot.worker.runners.shared_state import keep_errors


class StageLife:
    """A stage instance of this worker with its error policy.

    build: makes the stage, again for the policy `restart`; name: of the instance.
    """

    def __init__(self, name: str, build: Callable[[], Stage], on_error: ErrorPolicy) -> None:
        """Build the stage. Raises StageError if that fails."""
        self.name = name
        self.uses = ""
        """Name under which the stage is offered."""
        self.build = build
        try:
            self.stage = build()
        except RAISED as error:
            raise StageError(name, None, error) from error
        self._declare()
        self.on_error = on_error
        self.open = False
        """Whether the stage is to be closed: `setup` was called, `close` was not."""
        self.ready = False
        """Whether `setup` succeeded."""
        self.count = RunnerCount()
        self._copies = NO_COPIES

    def setup(self) -> None:
        """Set the stage up. Raises StageError."""
        self.open = True
        errors = np.geterr()
        try:
            self._copies = set_up(self.stage)
            keep_errors(self.stage, errors)
        except RAISED as error:
            raise StageError(self.name, None, error) from error
        self.ready = True

    def close(self) -> None:
        """Close the stage, once. Raises StageError, for outputs may be incomplete then."""
        if not self.open:
            return
        self.open = False
        try:
            self.stage.close()
            self._copies.check()
        except RAISED as error:
            if self.ready:  # else `setup` has raised already
                raise StageError(self.name, None, error) from error
        finally:
            self._copies.forget()

    def retire(self, stage: Stage) -> None:
        """Close the stage that was replaced."""
        try:
            stage.close()
        except RAISED as error:
            stage.context.warn(f"the stage that was replaced did not close: {text_of(error)}")

    def _declare(self) -> None:
        """Read the output types that the stage declares."""
        self.declared = ports(type(self.stage)).outputs
        self._only = self.declared[0].type if len(self.declared) == 1 else None
        """Type of all results but None, if the stage has one output; None for dataclasses of messages."""

    def _checked(self, result: Any, header: Header) -> Any:
        """The result; None if it is not what the stage declares. Raises StageError if the run is to fail."""
        try:
            check_returned(self.declared, result)
        except WrongOutput as error:
            recover(self, header, error)
            return None
        return result
