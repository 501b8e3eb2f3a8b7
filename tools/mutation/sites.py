"""Places in a module for mutations, and a random sample of mutations.

The changes are cosmic-ray's: comparisons, arithmetic, numbers, `and`, `or`, `not`, loops, handlers,
decorators. One is ours: a call whose result nobody uses is left out. A place counts once, however many
changes it allows.
"""

from __future__ import annotations

import difflib
import hashlib
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cosmic_ray.plugins
from cosmic_ray.ast import ast_nodes, get_ast
from cosmic_ray.mutating import mutate_code
from cosmic_ray.operators.operator import Operator

from mutation.tree import Mutant

ALIKE = ("_Eq_Is", "_NotEq_Is", "_Is_Eq", "_IsNot_NotEq")
"""Changes between equality and identity: for None, small integers and enumerations they are none."""
UNUSED = ("core/NoOp", "core/VariableInserter", "core/VariableReplacer")
OMIT = "OmitCall"


@dataclass(frozen=True)
class Site:
    """A place in a file and the changes that are possible there, each an operator and its occurrence.

    name: the same as long as its line is, whatever changes around it; line, lines, scope: as of a `Mutant`.
    """

    path: str
    name: str
    line: int
    changes: tuple[tuple[str, int], ...]
    lines: tuple[int, int]
    scope: tuple[tuple[int, int], ...] | None


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


def sites(root: Path, paths: Sequence[str]) -> list[Site]:
    """Every place in the files, in their order."""
    operators = _operators()
    return [site for path in paths for site in _sites_of(path, (root / path).read_text(), operators)]


def draw(root: Path, places: Sequence[Site], count: int, seed: int) -> list[Mutant]:
    """`count` random places, each with one of its mutations; those that do not compile are skipped.

    A place has its lot by its own name, so that an edit changes the sample only where it changes the code.
    """
    drawn: list[Mutant] = []
    for site in sorted(places, key=lambda site: _lot(seed, site)):
        if len(drawn) == count:
            break
        mutant = _mutant(root, site, *site.changes[_lot(seed, site) % len(site.changes)])
        if mutant is not None:
            drawn.append(mutant)
    return drawn


def _lot(seed: int, site: Site) -> int:
    return int.from_bytes(hashlib.sha256(f"{seed} {site.path} {site.name}".encode()).digest()[:8])


def _operators() -> dict[str, Operator]:
    names = [
        n for n in cosmic_ray.plugins.operator_names() if n not in UNUSED and not any(a in n for a in ALIKE)
    ]
    return {OMIT: OmitCall()} | {name: cosmic_ray.plugins.get_operator(name)() for name in names}


def _sites_of(path: str, source: str, operators: dict[str, Operator]) -> Iterator[Site]:
    changes: dict[tuple[tuple[int, int], str], list[tuple[str, int]]] = {}
    where: dict[tuple[int, int], Any] = {}
    nodes = list(ast_nodes(get_ast(source)))
    for name, operator in operators.items():
        occurrence = 0
        for node in nodes:
            for position, _ in operator.mutation_positions(node):
                changes.setdefault((position, name.split("_")[0]), []).append((name, occurrence))
                where[position] = node
                occurrence += 1
    text, named, bodies = source.splitlines(), Counter[str](), _bodies(nodes)
    for ((line, column), family), possible in sorted(changes.items()):
        node, code = where[line, column], text[line - 1]
        if not _in_annotation(node):
            name = f"{family} {column - len(code) + len(code.lstrip())} {code.strip()}"
            named[name] += 1  # equal lines are told apart by their number
            yield Site(
                path,
                f"{name} {named[name]}",
                line,
                tuple(possible),
                _statement(node, line),
                _scope(node, bodies),
            )


def _mutant(root: Path, site: Site, name: str, occurrence: int) -> Mutant | None:
    source = (root / site.path).read_text()
    operator = OmitCall() if name == OMIT else cosmic_ray.plugins.get_operator(name)()
    code = mutate_code(source, operator, occurrence)
    try:
        compile(code, site.path, "exec")
    except (SyntaxError, ValueError):
        return None
    lines = difflib.unified_diff(source.splitlines(), code.splitlines(), lineterm="", n=0)
    diff = "\n".join(line for line in list(lines)[2:] if not line.startswith("@@"))
    return Mutant(site.path, name, occurrence, site.line, site.lines, site.scope, diff, code)


def _is_call(node: Any) -> bool:
    last = node.children[-1] if node.type in ("atom_expr", "power") else None
    return last is not None and last.type == "trailer" and last.children[0].value == "("


def _ancestors(node: Any) -> Iterator[tuple[Any, Any]]:
    while node.parent is not None:
        yield node, node.parent
        node = node.parent


def _in_annotation(node: Any) -> bool:
    """Annotations are not evaluated."""
    for child, parent in _ancestors(node):
        if parent.type == "annassign" and parent.children[1] is child:
            return True
        if parent.type == "tfpdef" and parent.children[2] is child:
            return True
        if parent.type == "funcdef" and parent.annotation is child:
            return True
    return False


def _statement(node: Any, line: int) -> tuple[int, int]:
    """From the first line of the statement to that of the mutation: the lines that a trace may name."""
    for child, parent in _ancestors(node):
        if parent.type in ("suite", "file_input") or child.type in ("simple_stmt", "decorator"):
            return min(child.start_pos[0], line), line
    return line, line


def _bodies(nodes: Sequence[Any]) -> list[tuple[int, int]]:
    """First and last line of the body of each function."""
    return [_span(node.children[-1]) for node in nodes if node.type == "funcdef"]


def _scope(node: Any, bodies: Sequence[tuple[int, int]]) -> tuple[tuple[int, int], ...] | None:
    """None within a function, because its lines run in tests; else the functions that are defined here."""
    defined = _defined(node)
    if defined is None:
        return None
    within = [body for body in bodies if defined[0] <= body[0] and body[1] <= defined[1]]
    return tuple(within or bodies)


def _defined(node: Any) -> tuple[int, int] | None:
    """The lines of the function, class or module that a line defines; None within a function."""
    for child, parent in _ancestors(node):
        if parent.type == "lambdef":
            return None
        if parent.type == "funcdef":
            body = parent.children[-1]
            return None if child is body else _span(body)
        if parent.type == "decorated":
            return _span(parent.children[-1])
        if parent.type == "classdef":
            return _span(parent)
    return 1, 1 << 30


def _span(node: Any) -> tuple[int, int]:
    """First and last line of a definition, or of the statements of a body."""
    start = node.children[1].start_pos if node.type == "suite" else node.start_pos
    line, column = node.end_pos
    return start[0], line if column else line - 1
