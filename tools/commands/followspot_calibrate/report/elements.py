"""Elements of a page: text and attributes are escaped because the tree is written as a whole."""

from __future__ import annotations

from xml.etree.ElementTree import Element, tostring

__all__ = ["Element", "element", "html", "number"]


def element(tag: str, *children: Element | str, **attributes: object) -> Element:
    """An element with these children in this order.

    Attributes: `class_` is class, `data_p` is data-p.
    """
    names = {name: name.rstrip("_").replace("_", "-") for name in attributes}
    node = Element(tag, {names[name]: str(value) for name, value in attributes.items()})
    last: Element | None = None
    for child in children:
        if isinstance(child, Element):
            node.append(child)
            last = child
        elif last is None:
            node.text = (node.text or "") + child
        else:
            last.tail = (last.tail or "") + child
    return node


def html(node: Element) -> str:
    """The element as HTML text."""
    return tostring(node, encoding="unicode", method="html")


def number(value: float, digits: int = 2) -> str:
    """A measured value for people; a dash if there is none."""
    return f"{value:.{digits}f}" if value == value else "–"
