"""Tables of a report in a script."""

from __future__ import annotations

import sys

import pytest

import followspot as fs


def test_a_table_without_pandas_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(ImportError, match="pip install pandas"):
        fs.Table(["a"], [[1]]).to_pandas()
