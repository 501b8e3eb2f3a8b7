"""What `--help` says."""

from __future__ import annotations

import pytest

from followspot.cli.parser import CORE
from followspot.plugins.hooks import Command
from followspot.plugins.loaded_hooks import load_commands


@pytest.mark.parametrize("command", [*CORE, *load_commands()], ids=lambda command: command.title)
def test_each_command_has_an_example(command: Command) -> None:
    assert f"\n  followspot {command.title}" in command.help
