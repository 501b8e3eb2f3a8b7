"""Parts that cameras, sensors and targets of a room document have in common: limits, words, tags, sources."""

from __future__ import annotations

from followspot.errors import Mistake
from followspot.room import SETS, StageUse, Tags
from followspot.valid_values.names import is_name
from followspot.yaml.form import Form, kind_of
from followspot.yaml.node import Node

MAX_TAGS = 100
"""Most tags of one camera, sensor or target, and most values of one tag."""
TOLERANCE = 1e-3
"""Largest deviation of R R^T from the identity, and of a plane's normal from unit length."""
ROUNDING = 1e-9
"""Deviation from a unit sum or length that is not corrected: a written room is read back bit for bit."""
FAR = 1e6
"""Largest length of anything in a room, m."""
_TAKEN = frozenset(("name", "kind", "model", "host", *SETS, *SETS.values()))
"""Words that selectors use for something else."""


def word(form: Form, key: str) -> str | None:
    """A free word, required."""
    found = form.text(key, required=True)
    if found is None or is_name(found):
        return found
    form.wrong(form.entries[key], f'{key} cannot be "{found}"', "one word: letters, digits, _ and -")
    return None


def tags_of(form: Form) -> Tags:
    """The tags: name -> one word, or a list of words."""
    entries = form.mapping("tags")
    if len(entries) > MAX_TAGS:
        form.wrong(form.entries["tags"], f"{len(entries)} tags, at most {MAX_TAGS} are allowed")
        return {}
    tags = {}
    for tag, node in entries.items():
        values = node.value if isinstance(node.value, tuple) else (node,)
        if not is_name(tag) or tag in _TAKEN:
            text = f'"{tag}" cannot be a tag'
            taken = "selectors use it for something else; write another word"
            remedy = taken if tag in _TAKEN else "use 1 to 100 letters, digits, _ and -"
            form.mistakes.append(Mistake(node.key, text, remedy))
        elif not 0 < len(values) <= MAX_TAGS:
            form.wrong(node, f"tag {tag} has {len(values)} values", f"write from 1 to {MAX_TAGS} words")
        else:
            tags[tag] = tuple(dict.fromkeys(_value(tag, value, form) for value in values))
    return tags


def _value(tag: str, node: Node, form: Form) -> str:
    """One value of a tag; a whole number is read as a word."""
    number = isinstance(node.value, int) and not isinstance(node.value, bool)
    found = str(node.value) if number or isinstance(node.value, str) else ""
    if not is_name(found):
        form.wrong(node, f"tag {tag} cannot be {kind_of(node)}", "a word: letters, digits, _ and -")
    return found


def stage_use(node: Node, noun: str, folder: str | None, mistakes: list[Mistake]) -> StageUse | None:
    """A stage that a room names, with its parameters; folder: see `room_of`."""
    form = Form(node, noun, ("uses", "with") if folder is not None else ("uses", "with", "folder"), mistakes)
    uses = form.text("uses", required=True)
    params = form.values("with")
    if folder is None:
        folder = form.text("folder") or "."
    return None if uses is None else StageUse(uses, params, folder)
