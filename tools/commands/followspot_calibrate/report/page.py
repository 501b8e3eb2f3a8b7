"""A page as data, and the HTML file that shows it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path
from typing import Literal

from followspot.errors import writing
from followspot_calibrate.report.elements import Element, element, html

Verdict = Literal["good", "look", "bad"]
"""good: nothing to do; look: to be examined; bad: not to be used."""


@dataclass(frozen=True, eq=False)
class Section:
    """A part of a page under a heading; note: one line that says how to read it."""

    title: str
    content: Sequence[Element]
    note: str = ""


@dataclass(frozen=True, eq=False)
class Page:
    """The content of a page.

    title: which calibration of which room; verdict: see `Verdict`; summary: the verdict in a sentence;
    warnings: each with its remedy.
    """

    title: str
    verdict: Verdict
    summary: str
    warnings: Sequence[str] = ()
    sections: Sequence[Section] = ()


def write_report(path: Path, page: Page) -> None:
    """Write the page as one HTML file without any outside resource. Raises FollowspotError."""
    with writing(path):
        path.write_text("<!DOCTYPE html>\n" + html(document(page)) + "\n", encoding="utf-8")


def document(page: Page) -> Element:
    """The whole page as a tree."""
    head = element(
        "head",
        element("meta", charset="utf-8"),
        element("meta", name="viewport", content="width=device-width, initial-scale=1"),
        element("title", page.title),
        element("style", _resource("page.css")),
    )
    warnings = element("ul", *(element("li", text) for text in page.warnings), class_="warnings")
    body = element(
        "body",
        element("h1", page.title),
        element("p", page.summary, class_=f"verdict {page.verdict}"),
        *([warnings] if page.warnings else []),
        *(_section(section) for section in page.sections),
        element("script", _resource("scene.js")),
    )
    return element("html", head, body, lang="en")


def _section(section: Section) -> Element:
    note = [element("p", section.note, class_="note")] if section.note else []
    return element("section", element("h2", section.title), *note, *section.content)


def _resource(name: str) -> str:
    return (files(__package__) / name).read_text(encoding="utf-8")
