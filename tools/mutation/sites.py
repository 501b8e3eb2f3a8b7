"""A random sample of the places at which cosmic-ray, and one operator of ours, can change the code."""

from __future__ import annotations

import ast
import hashlib
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import cosmic_ray.plugins
from cosmic_ray.ast import get_ast
from cosmic_ray.commands.init import init
from cosmic_ray.operators.operator import Operator
from cosmic_ray.work_db import WorkDB
from cosmic_ray.work_item import MutationSpec, WorkItem

LEFT_OUT = ("_Eq_Is", "_NotEq_Is", "_Is_Eq", "_IsNot_NotEq", "NoOp", "VariableInserter", "VariableReplacer")
"""Operators that change nothing, or nothing for None, small integers and enumerations."""


class OmitCall(Operator):  # type: ignore[misc]
    """Puts `pass` in the place of a statement that is a call."""

    def mutation_positions(self, node: Any) -> Iterator[Any]:
        """The statement, if it is a call."""
        if node.type == "simple_stmt" and _is_call(node.children[0]):
            yield node.children[0].start_pos, node.children[0].end_pos

    def mutate(self, node: Any, index: int) -> Any:
        """The statement with `pass` for its call."""
        leaf = get_ast("pass\n").children[0].children[0]
        leaf.prefix, leaf.parent = node.get_first_leaf().prefix, node
        node.children[0] = leaf
        return node

    @classmethod
    def examples(cls) -> tuple[()]:
        """None."""
        return ()


cosmic_ray.plugins.OPERATOR_PROVIDERS["omit"] = {"call": OmitCall}


def draw(paths: Sequence[Path], count: int, seed: int) -> list[WorkItem]:
    """`count` random places, each with one of its changes. paths: relative to the working directory.

    A place has its lot by its own line, so that an edit changes the sample only where it changes the code.
    """
    drawn: dict[bytes, tuple[bytes, MutationSpec]] = {}
    for path in paths:
        text = path.read_text()
        lines, annotated = text.splitlines(), _annotated(text)
        for mutation in _all(path):
            if mutation.start_pos in annotated or any(name in mutation.operator_name for name in LEFT_OUT):
                continue
            row, column = mutation.start_pos
            family = mutation.operator_name.split("_")[0]
            place = _hash(seed, path, family, lines[row - 1].strip(), column)
            lot = _hash(seed, place, mutation.operator_name)
            drawn[place] = min(drawn.get(place, (lot, mutation)), (lot, mutation), key=lambda pair: pair[0])
    chosen = [drawn[place][1] for place in sorted(drawn)[:count]]
    return [WorkItem.single(_key(mutation), mutation) for mutation in chosen]


def _all(path: Path) -> Iterator[MutationSpec]:
    """Every change of a file."""
    found = WorkDB(":memory:", WorkDB.Mode.create)
    init([path], found, {})
    yield from (item.mutations[0] for item in found.work_items)
    found.close()


def _key(mutation: MutationSpec) -> str:
    """The same for the same change of the same file."""
    path = mutation.module_path
    return _hash(path, path.read_text(), mutation.operator_name, mutation.occurrence).hex()[:16]


def _hash(*parts: object) -> bytes:
    return hashlib.sha256(repr(tuple(map(str, parts))).encode()).digest()


def _is_call(node: Any) -> bool:
    last = node.children[-1] if node.type in ("atom_expr", "power") else None
    return last is not None and last.type == "trailer" and last.children[0].value == "("


def _annotated(text: str) -> set[tuple[int, int]]:
    """Line and column of all characters in annotations, which are not evaluated."""
    lines = text.splitlines()
    found = set()
    for node in ast.walk(ast.parse(text)):
        for name in ("annotation", "returns"):
            part = getattr(node, name, None)
            if part is not None:
                for row in range(part.lineno, part.end_lineno + 1):
                    first = part.col_offset if row == part.lineno else 0
                    last = part.end_col_offset if row == part.end_lineno else len(lines[row - 1])
                    found |= {(row, column) for column in range(first, last)}
    return found
