"""Text with tags in it, or an XML document, as one stream of events with the lines where they stand.

In plain text a ``<`` is the start of a tag only if a tag follows: ``<`` with a name, well-formed attributes and ``>``.
``3 < 4``, ``I <3 you`` and ``a <- b`` are text and spoken. ``&lt; &gt; &amp; &quot; &apos;`` and ``&#960;`` stand for
their characters. A document that begins with an XML declaration or one of the roots ``script``, ``speak`` and ``bml``
is XML and read strictly.

``<angry>...</angry>`` is short for ``<emotion name="angry">...</emotion>``, ``<angry 0.6>`` for the same at 0.6; one
that is not closed holds to the end of the text, or until the next that is not.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator
from dataclasses import dataclass
from difflib import get_close_matches
from functools import cache, cached_property
from html import unescape
from typing import Literal
from xml.parsers import expat

from mien.core.emotions import NOUNS, emotion_called, emotions
from mien.core.errors import InputError, near_names
from mien.core.limits import check_size

__all__ = ["ROOTS", "Event", "is_document", "read_document", "read_tagged_text", "unknown_tag", "with_long_tags"]

ROOTS = ("script", "speak", "bml")
"""Root elements of the documents that can be read: mien's own, SSML, BML."""

_OWN_NAMESPACES = ("mien", "www.w3.org/2001/10/synthesis", "bml")
"""What the names of namespaces hold whose elements are read like the document's own."""
_NAME = r"[A-Za-z_][\w.:-]*"
_ATTRIBUTE = rf"""\s+({_NAME})\s*=\s*("[^"<]*"|'[^'<]*')"""
_TAG = re.compile(rf"<(?:(/)\s*({_NAME})\s*|({_NAME})((?:{_ATTRIBUTE})*)\s*(/?))>")
_ENTITY = re.compile(r"&(?:lt|gt|amp|quot|apos|#\d{1,7}|#[xX][0-9a-fA-F]{1,6});")
_ROOT = re.compile(rf"<(?:[\w.-]+:)?({'|'.join(ROOTS)})[\s/>]")
_HALF_TAG = re.compile(rf"</?({_NAME})")
_CLOSING = re.compile(rf"</\s*({_NAME})")
_BLANKS = re.compile(r"\s*")
_PROLOGUE = (("<?xml", "?>"), ("<!--", "-->"), ("<!DOCTYPE", ">"))
"""What may stand ahead of a root, and how it ends."""
_MOST_UNKNOWN = 200
"""Different unknown names in angle brackets that are compared with the known ones; what follows is text."""


@dataclass(frozen=True)
class Event:
    """One piece of a script.

    Attributes
    ----------
    kind : {"text", "open", "close"}
    text : str
        The text, or the name of the element.
    line : int
        From 1.
    attributes : tuple of (str, str)
    empty : bool
        Whether an element opened as ``<NAME/>``.
    foreign : bool
        Whether the element is of another vocabulary than the document, by its namespace.
    strange : tuple of str
        Attributes of other vocabularies.
    """

    kind: Literal["text", "open", "close"]
    text: str
    line: int
    attributes: tuple[tuple[str, str], ...] = ()
    empty: bool = False
    foreign: bool = False
    strange: tuple[str, ...] = ()


def is_document(text: str) -> bool:
    """Whether a text is an XML document rather than text with tags in it.

    Examples
    --------
    >>> is_document('<?xml version="1.0"?><speak>Hello.</speak>'), is_document("<HeadNod/> Hello.")
    (True, False)
    """
    return text.lstrip("\ufeff \t\r\n").startswith("<?xml") or _ROOT.match(text, _after_prologue(text)) is not None


def _after_prologue(text: str) -> int:
    """Where the root stands, if there is one: behind declarations, comments and blanks, passed over one by one."""
    place = _end_of_blanks(text, 0)
    while True:
        end = next((end for start, end in _PROLOGUE if text.startswith(start, place)), None)
        found = -1 if end is None else text.find(end, place)
        if end is None or found < 0:
            return place
        place = _end_of_blanks(text, found + len(end))


def _end_of_blanks(text: str, place: int) -> int:
    found = _BLANKS.match(text, place)
    return found.end() if found else place


def read_tagged_text(text: str, known: Collection[str], source: str) -> Iterator[Event]:
    """Events of plain text with tags in it.

    Parameters
    ----------
    text : str
    known : collection of str
        Names of tags; ``<`` with one of them has to be a whole tag, any other tag is refused.
    source : str
        For messages.

    Raises
    ------
    InputError
        If a tag is not known or not well formed.
    """
    place, line = 0, 1
    plain: list[str] = []
    begun = 1
    unknown = _UnknownTags(text, known)
    last_comment = text.rfind("-->")
    while place < len(text):
        here = text.find("<", place)
        here = len(text) if here < 0 else here
        plain.append(text[place:here])
        line += text.count("\n", place, here)
        if here == len(text):
            break
        if here < last_comment and text.startswith("<!--", here) and (end := text.find("-->", here + 4)) >= 0:
            place = end + 3
            line += text.count("\n", here, place)
            continue
        found = _TAG.match(text, here)
        if found is None:
            _refuse_half_tag(text, here, known, f"{source}, line {line}")
            plain.append("<")
            place = here + 1
            continue
        event = _event(found, line)
        if event.text in known:
            yield from _plain(plain, begun)
            plain, begun = [], line
            yield event
        elif unknown.is_text(event):
            plain.append(found[0])
        else:
            raise unknown_tag(event, known, source)
        place = found.end()
        line += text.count("\n", here, place)
    yield from _plain(plain, begun)


class _UnknownTags:
    """Which of what looks like unknown tags is rather text, as in ``a<b>c``: bare, never closed, like no known tag."""

    def __init__(self, text: str, known: Collection[str]) -> None:
        self._text, self._known = text, known
        self._judged: dict[str, bool] = {}

    @cached_property
    def _closed(self) -> frozenset[str]:
        return frozenset(_CLOSING.findall(self._text))

    def is_text(self, event: Event) -> bool:
        """Whether a tag whose name is not known is text."""
        if event.kind == "close" or event.empty or event.attributes or event.text in self._closed:
            return False
        if event.text not in self._judged:
            if len(self._judged) >= _MOST_UNKNOWN:
                return True
            self._judged[event.text] = not get_close_matches(event.text[:80], self._known, n=1, cutoff=0.75)
        return self._judged[event.text]


def unknown_tag(event: Event, known: Collection[str], source: str) -> InputError:
    """The error for a tag that is not known, with the nearest ones that are."""
    near = near_names(event.text, known)
    guess = f"did you mean {' or '.join(f'<{name}>' for name in near)}?" if near else "docs/script.md lists the tags;"
    return InputError(
        f"{source}, line {event.line}: unknown tag <{event.text[:80]}>: {guess} write &lt; where it is meant as text"
    )


def _plain(parts: list[str], line: int) -> Iterator[Event]:
    text = "".join(parts)
    if text:
        yield Event("text", _ENTITY.sub(lambda entity: unescape(entity[0]), text), line)


def _event(found: re.Match[str], line: int) -> Event:
    if found[1]:
        return Event("close", found[2], line)
    pairs = re.findall(_ATTRIBUTE, found[4])
    return Event("open", found[3], line, tuple((name, unescape(value[1:-1])) for name, value in pairs), bool(found[7]))


def _refuse_half_tag(text: str, here: int, known: Collection[str], where: str) -> None:
    name = _HALF_TAG.match(text, here)
    if name is None or name[1] not in known:
        return
    rest = text[here : here + 40].split("\n")[0]
    raise InputError(
        f'{where}: the tag {rest!r} is not well formed: expected <{name[1]} name="value" .../> '
        "with every value in quotes and '>' at its end"
    )


class _Namespaces:
    """Which elements are of the document's own vocabulary.

    Documents in the wild leave namespaces out, or take any prefix; so what is of the root's namespace, of mien's, or of
    one that no prefix was bound to, is the document's own.
    """

    def __init__(self) -> None:
        self.bound: list[dict[str, str]] = [{}]
        self.root: str | None = None

    def opened(self, name: str, attributes: dict[str, str]) -> bool:
        """Whether an element that opens is foreign."""
        new = {key.partition(":")[2]: value for key, value in attributes.items() if key.split(":")[0] == "xmlns"}
        self.bound.append(new)
        prefix = name.rpartition(":")[0]
        space = next((scope[prefix] for scope in reversed(self.bound) if prefix in scope), prefix)
        if self.root is None:
            self.root = space
        return space not in (self.root, "") and not any(word in space for word in _OWN_NAMESPACES)

    def closed(self) -> None:
        """An element was closed."""
        self.bound.pop()


def read_document(text: str, source: str) -> Iterator[Event]:
    """Events of an XML document, names without their namespace prefix.

    Raises
    ------
    InputError
        If it is not well-formed XML, or declares entities of its own (which could blow up).
    """
    events: list[Event] = []
    parser = expat.ParserCreate("utf-8")  # whatever it declares: it was decoded before
    parser.buffer_text = True
    opened: list[tuple[str, int]] = []
    spaces = _Namespaces()

    def start(name: str, attributes: dict[str, str]) -> None:
        where = f"{source}, line {parser.CurrentLineNumber}"
        check_size("levels", len(opened) + 1, where)
        check_size("elements", len(events), where)
        foreign, name = spaces.opened(name, attributes), name.rpartition(":")[2]
        opened.append((name, parser.CurrentLineNumber))
        plain = {key: value for key, value in attributes.items() if not key.startswith(("xmlns", "xsi:"))}
        pairs = tuple((key, value) for key, value in plain.items() if ":" not in key or key.startswith("xml:"))
        strange = tuple(key for key in plain if ":" in key and not key.startswith("xml:"))
        events.append(Event("open", name, parser.CurrentLineNumber, pairs, foreign=foreign, strange=strange))

    def end(name: str) -> None:
        opened.pop()
        spaces.closed()
        events.append(Event("close", name.rpartition(":")[2], parser.CurrentLineNumber))

    def data(content: str) -> None:
        events.append(Event("text", content, parser.CurrentLineNumber))

    def entity(name: str, *_: object) -> None:
        raise InputError(f"{source}, line {parser.CurrentLineNumber}: entity {name!r}: own entities are not read")

    def skipped_entity(name: str, parameter: bool) -> None:
        sign = unescape(f"&{name};")
        if not parameter and sign == f"&{name};":
            raise InputError(f"{source}, line {parser.CurrentLineNumber}: the entity &{name}; is not known")
        events.append(Event("text", "" if parameter else sign, parser.CurrentLineNumber))

    parser.StartElementHandler, parser.EndElementHandler = start, end
    parser.CharacterDataHandler, parser.EntityDeclHandler = data, entity
    parser.SkippedEntityHandler = skipped_entity
    try:
        parser.Parse(text.lstrip("\ufeff \t\r\n").encode("utf-8"), True)
    except expat.ExpatError as problem:
        skipped = text[: len(text) - len(text.lstrip("\ufeff \t\r\n"))].count("\n")
        unclosed = f"; <{opened[-1][0]}> of line {opened[-1][1] + skipped} is open there" if opened else ""
        message = expat.errors.messages[problem.code]
        raise InputError(
            f"{source}, line {problem.lineno + skipped}: not well-formed XML: {message}{unclosed}"
        ) from problem
    yield from events


@cache
def _short_tag() -> re.Pattern[str]:
    words = "|".join(sorted({*emotions(), *NOUNS}, key=len, reverse=True))
    return re.compile(rf"<(?P<end>/)?(?P<name>{words})(?:[ \t]+(?P<strength>[01]?\.?\d{{1,6}}))?[ \t]*>")


def with_long_tags(text: str, known: Collection[str] = ()) -> tuple[str, tuple[str, ...]]:
    """A text in which short tags of emotions are written out, and which of them are never closed.

    Every other character stays, lines too.

    Parameters
    ----------
    text : str
    known : collection of str
        Names that mean something else.

    Examples
    --------
    >>> with_long_tags("<angry 0.6>No!</angry> Well.")
    ('<emotion name="angry" intensity="0.6">No!</emotion> Well.', ())
    >>> with_long_tags("Oh. <joy>It is you!")
    ('Oh. <emotion name="happy">It is you!</emotion>', ('joy',))
    """
    pieces, place, opened, held = [], 0, list[str](), list[str]()
    tags = [found for found in _short_tag().finditer(text) if found["name"] not in known]
    ends = [found["name"] for found in tags if found["end"]]
    for found in tags:
        name = found["name"]
        pieces.append(text[place : found.start()])
        place = found.end()
        if found["end"]:
            ends.remove(name)
            pieces.append("</emotion>")
            continue
        if opened:
            pieces.append("</emotion>")
            opened.pop()
        if name not in ends:
            opened.append(name)
            held.append(name)
        strength = f' intensity="{found["strength"]}"' if found["strength"] else ""
        pieces.append(f'<emotion name="{emotion_called(name)}"{strength}>')
    return "".join([*pieces, text[place:], "</emotion>" * len(opened)]), tuple(dict.fromkeys(held))
