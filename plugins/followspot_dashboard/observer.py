"""Base of the stages that observe a port and send its messages to a reader or the page."""

from __future__ import annotations

from typing import Any

from followspot import Field, InputPath, Stage, StageParams
from followspot_dashboard.line import Line, PostLine, line_of


class Observer(Stage):
    """Base of the stages that observe a port; without a reader they ignore every message."""

    class Params(StageParams):
        """The observed port and its reader."""

        folder: InputPath | None = Field(
            None, description="folder of the reader's sockets, if the reader is on this host"
        )
        port: str = Field("", description="observed port, STAGE.PORT; by default this stage's name")

    params: Any
    tap = True
    line: Line | PostLine | None = None

    def setup(self) -> None:
        """Connect to the reader."""
        self.port = self.params.port or self.context.name
        self.line = line_of(self.context, self.params.folder)

    def close(self) -> None:
        """Disconnect from the reader."""
        if self.line is not None:
            self.line.close()
        self.line = None
