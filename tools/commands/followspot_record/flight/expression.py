"""Expressions over figures: words, numbers and quoted texts, joined by comparisons, sums and `and`.

    expression = part ("or" part)*          part = negation ("and" negation)*
    negation = "not" negation | comparison  comparison = sum [("<" | "<=" | ">" | ">=" | "==" | "!=") sum]
    sum = product (("+" | "-") product)*    product = sign (("*" | "/") sign)*
    sign = "-" sign | atom                  atom = NUMBER | 'TEXT' | WORD | WORD "(" expression ")"
                                                   | "(" expression ")"

Expressions are parsed by this grammar, and never evaluated by Python.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass

from followspot.errors import Guess, InputError, Mistake, Place

_TOKEN = re.compile(
    r"\s*(?:(?P<number>\d+(?:\.\d*)?(?:[eE][-+]?\d+)?|\.\d+)"
    r"|(?P<text>'[^']*'|\"[^\"]*\")|(?P<word>[A-Za-z_]\w*)|(?P<sign><=|>=|==|!=|[-+*/()<>]))"
)
_DEEPEST = 50
_LONGEST = 400
"""Pieces of an expression, which bound how deep its tree is: each operator may be a level."""
COMPARISONS = ("<", "<=", ">", ">=", "==", "!=")


@dataclass(frozen=True)
class Token:
    """A piece of an expression. kind: number, text, word, sign or end; start: its first column, from 0."""

    kind: str
    text: str
    start: int


@dataclass(frozen=True)
class Expression:
    """A node. form: number, text, word, call, negative, or an operator such as `<`; parts: its operands."""

    form: str
    token: Token
    parts: tuple[Expression, ...] = ()


@dataclass(frozen=True)
class Source:
    """The text that the user wrote, for mistakes. option: that it was given to; offset: of the expression."""

    option: str
    text: str
    offset: int = 0

    def mistake(self, token: Token, text: str, remedy: str | Guess) -> InputError:
        """A mistake at a token."""
        column = self.offset + token.start + 1
        place = Place(self.option, 1, column, max(1, len(token.text)), written=self.text)
        return InputError([Mistake(place, text, remedy)])


def parse(source: Source) -> Expression:
    """The expression of a text from `source.offset` on. Raises InputError."""
    parser = _Parser(source, _tokens(source))
    found = parser.either()
    if parser.now.kind != "end":
        raise source.mistake(parser.now, f'"{parser.now.text}" does not belong here', _HELP)
    return found


_HELP = "write for example: count(state == tracked) < 4 and dropped > 0"


def _tokens(source: Source) -> list[Token]:
    text = source.text[source.offset :]
    found, at = [], 0
    while text[at:].strip():
        match = _TOKEN.match(text, at)
        if match is None or match.lastgroup is None:
            start = at + len(text[at:]) - len(text[at:].lstrip())
            sign = Token("sign", text[start], start)
            remedy = "compare with ==" if sign.text == "=" else _HELP
            raise source.mistake(sign, f'"{sign.text}" means nothing here', remedy)
        found.append(Token(match.lastgroup, match[match.lastgroup], match.start(match.lastgroup)))
        if len(found) > _LONGEST:
            raise source.mistake(found[-1], f"this has more than {_LONGEST} pieces", "write it more simply")
        at = match.end()
    return [*found, Token("end", "", len(text.rstrip()))]


class _Parser:
    """Recursive descent, one method for each rule of the grammar."""

    def __init__(self, source: Source, tokens: list[Token]) -> None:
        self._source = source
        self._tokens = tokens
        self._at = self._depth = 0

    @property
    def now(self) -> Token:
        return self._tokens[self._at]

    def either(self) -> Expression:
        return self._chain(self._both, ("or",))

    def _both(self) -> Expression:
        return self._chain(self._negation, ("and",))

    def _negation(self) -> Expression:
        if self.now.text == "not":
            return self._nested("not", self._negation)
        left = self._sum()
        if self.now.text in COMPARISONS:
            sign = self._take()
            left = Expression(sign.text, sign, (left, self._sum()))
        return left

    def _sum(self) -> Expression:
        return self._chain(self._product, ("+", "-"))

    def _product(self) -> Expression:
        return self._chain(self._sign, ("*", "/"))

    def _sign(self) -> Expression:
        return self._nested("negative", self._sign) if self.now.text == "-" else self._atom()

    def _atom(self) -> Expression:
        token = self._take()
        if token.text == "(":
            return self._closed()
        if token.kind == "word" and self.now.text == "(":
            self._take()
            return Expression("call", token, (self._closed(),))
        if token.kind not in ("number", "text", "word"):
            what = f'"{token.text}" stands' if token.text else "the expression ends"
            raise self._source.mistake(token, f"{what} where a figure belongs", _HELP)
        return Expression(token.kind, token)

    def _closed(self) -> Expression:
        """The expression before a closing bracket."""
        self._deeper()
        found = self.either()
        if self.now.text != ")":
            raise self._source.mistake(self.now, "a bracket is not closed", "write )")
        self._take()
        self._depth -= 1
        return found

    def _nested(self, form: str, rule: Callable[[], Expression]) -> Expression:
        token = self._take()
        self._deeper()
        found = Expression(form, token, (rule(),))
        self._depth -= 1
        return found

    def _chain(self, rule: Callable[[], Expression], signs: tuple[str, ...]) -> Expression:
        """Operands of one rank, joined from left to right."""
        left = rule()
        while self.now.kind in ("sign", "word") and self.now.text in signs:
            sign = self._take()
            left = Expression(sign.text, sign, (left, rule()))
        return left

    def _deeper(self) -> None:
        self._depth += 1
        if self._depth > _DEEPEST:
            raise self._source.mistake(self.now, "this is nested too deeply", "write it more simply")

    def _take(self) -> Token:
        token = self.now
        self._at = min(self._at + 1, len(self._tokens) - 1)
        return token
