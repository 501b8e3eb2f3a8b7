"""Reads how the cameras of a room are triggered together."""

from __future__ import annotations

from collections.abc import Collection
from typing import cast

from followspot.errors import did_you_mean
from followspot.room import Match, Sync, Trigger
from followspot.yaml.form import Form

KEYS = ("trigger", "camera", "rate", "device_key", "group_key", "group_mask", "match")
TRIGGERS = ("line", "software", "action")
MATCHES = ("number", "time")
LARGEST_KEY = (1 << 32) - 1


def sync_of(form: Form, cameras: Collection[str]) -> Sync | None:
    """The section `sync` of a room; None if it has none, or one with mistakes, which are noted."""
    node = form.get("sync")
    if node is None or node.value is None:
        return None
    own = Form(node, "sync", KEYS, form.mistakes)
    trigger = own.text("trigger", required=True, choices=TRIGGERS)
    leader = own.text("camera", required=trigger in ("line", "action"))
    if leader is not None and leader not in cameras:
        text = f'there is no camera "{leader}"'
        own.wrong(own.entries["camera"], text, did_you_mean(leader, cameras, "cameras"))
    rate = own.number("rate", least=0.01, most=10_000, required=trigger in ("software", "action"))
    keys = [_key(own, name) for name in ("device_key", "group_key", "group_mask")]
    match = own.text("match", choices=MATCHES) or "number"
    if trigger is None:
        return None
    return Sync(
        cast(Trigger, trigger), leader or "", rate or 0.0, keys[0], keys[1], keys[2], cast(Match, match)
    )


def _key(form: Form, name: str) -> int:
    """A key of action commands, 1 if it is not written."""
    value = form.number(name, least=0, most=LARGEST_KEY)
    if value is not None and value % 1:
        form.wrong(form.entries[name], f"{name} is no whole number", "write 1")
    return 1 if value is None else int(value)
