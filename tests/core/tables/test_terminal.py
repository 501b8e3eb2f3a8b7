"""Tables as people read them in a file or at the end of a pipe."""

from __future__ import annotations

import pytest

from followspot.tables.terminal import table


def test_columns_are_as_wide_as_their_widest_cell_and_lines_are_never_wrapped() -> None:
    wide = "x" * 300
    assert table(("edge", "sent"), [("a -> b", "7"), (wide, "1234567")]).splitlines() == [
        f"  {'edge':<300}     sent",
        f"  {'a -> b':<300}        7",
        f"  {wide}  1234567",
    ]


def test_a_cell_is_shown_as_it_is(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("FORCE_COLOR", "1")
    text = table(("stage [hooks]", "problem"), [("[red]x[/red]", ":smile: http://a 0.5 None"), ("", "日本")])
    assert text.splitlines() == [
        "  stage [hooks]                    problem",
        "  [red]x[/red]   :smile: http://a 0.5 None",
        "                                      日本",
    ]


def test_a_table_without_rows_is_its_head() -> None:
    assert table(("port", "messages", ""), []) == "  port  messages"
