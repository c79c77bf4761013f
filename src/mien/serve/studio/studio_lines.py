"""The text of a line, read and measured before a voice or an aligner is asked: a short text can ask for hours."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator
from textwrap import shorten
from typing import TYPE_CHECKING

from mien.core.errors import InputError
from mien.serve.studio.requests import FieldError
from mien.serve.studio.settings import Limits
from mien.text.commands import shipped_library
from mien.text.languages import read_words
from mien.text.script import Script
from mien.text.script_reading import read_script
from mien.text.sync_points import Moment, plain

__all__ = ["beginnings_of", "checked_script", "named"]

if TYPE_CHECKING:
    from mien.serve.studio.studio_takes import Take

_LONG = 16
"""Words; a shorter text is made at once."""
_FIRST, _LEAST = 12, 4
"""Words of a first beginning: at most, where a comma allows it, and at least."""
_TAG = re.compile(r"<[^<>]*>|\[[^\][\n]{1,40}\]|\{[^{}]*\}")
_WORDS_PER_SECOND = 4.0
"""Nobody speaks many more, so a text of more words than this makes more sound than is taken."""


def checked_script(text: str, language: str | None, limits: Limits) -> Script:
    """Read a line; never the name of a file.

    Raises
    ------
    FieldError
        If it cannot be read, or would make more sound than the studio takes.
    """
    try:
        script = read_script(text)
        words = len(read_words(script.text, language or script.language).words) if script.text.strip() else 0
        seconds = words / _WORDS_PER_SECOND + sum(segment.silence or 0.0 for segment in script.segments) / 1000
        seconds = max([seconds, *_moments(script), *_lengths(script)])
    except InputError as problem:
        raise FieldError("text", str(problem)) from problem
    if seconds > limits.seconds:
        told = f"at least {seconds:.0f} s of sound; the studio takes {limits.seconds:.0f} s"
        raise FieldError("text", f"the line would make {told}")
    return script


def beginnings_of(text: str) -> tuple[str, ...]:
    """Beginnings of a long text, by whole sentences, each about twice the one before; () of a short one.

    A tag that is open where a beginning ends is closed there. The first beginning of a text whose first sentence is
    long ends at a comma of it.

    Examples
    --------
    >>> [len(beginning.split()) for beginning in beginnings_of("Well. " + "I never said that. " * 9)]
    [1, 5, 13]
    >>> beginnings_of("<angry>Stop it. " + "I never said that. " * 5 + "</angry>")
    ('<angry>Stop it.</angry>', '<angry>Stop it. I never said that.</angry>')
    >>> beginnings_of("I never said that.")
    ()
    """
    plain = _TAG.sub(lambda tag: "\0" * len(tag[0]), text)  # as long as the text, without what is in tags

    def words(end: int) -> int:
        return len(plain[:end].replace("\0", "").split())

    total, found, least = words(len(text)), list[str](), 1
    if total <= _LONG:
        return ()
    ends = [match.end(1) for match in re.finditer(r"([.!?…。！？]+[\"'”’)]*)(?=[\s\0]+\S)", plain)]
    if not ends or words(ends[0]) > _FIRST:
        commas = (match.end() for match in re.finditer(r"[,;:—–](?=[\s\0])", plain))
        ends = [*(end for end in commas if _LEAST <= words(end) <= _FIRST)][-1:] + ends
    for end in ends:
        if words(end) >= least and 2 * words(end) < total:
            found.append(text[:end] + _closing(text[:end], text[end:]))
            least = 2 * words(end)
    return tuple(found)


def _closing(begun: str, rest: str) -> str:
    """The closing tags of what is open at the end of a beginning, and closed in the rest."""
    open_tags = list[str]()
    for tag in _TAG.findall(begun):
        name = re.match(r"</?([A-Za-z][\w:.-]*)", tag)
        if name is None or tag.endswith("/>"):
            continue
        if not tag.startswith("</"):
            open_tags.append(name[1])
        elif name[1] in open_tags:
            del open_tags[len(open_tags) - 1 - open_tags[::-1].index(name[1]) :]
    return "".join(f"</{name}>" for name in reversed(open_tags) if f"</{name}" in rest)


def named(take: Take, others: Collection[str] = ()) -> str:
    """What a new take is called: the beginning of its text by whole words, with a number if others have that name."""
    text = " ".join(re.sub(r"<[^<>]*>", "", take.animation.utterance.text).split()) or "take"
    name, number = shorten(text, 42, placeholder=" …") if " " in text[:42] else text[:42], 2
    found = name
    while found in others:
        found, number = f"{name} ({number})", number + 1
    return found


def _moments(script: Script) -> Iterator[float]:
    """Seconds at which something is asked for, as far as they stand in the text."""
    moments: list[Moment | None] = [segment.start for segment in script.segments]
    moments += [moment for item in script.commands for moment in (item.at, item.until)]
    moments += [moment for curve in script.curves for moment, _ in curve.keys]
    moments += [moment for item in script.emotions for moment in (item.start, item.end)]
    return (moment.offset / 1000 for moment in moments if moment is not None)


def _lengths(script: Script) -> Iterator[float]:
    """Seconds that each command lasts."""
    library = shipped_library()
    for item in script.commands:
        if item.until is None:
            for curve in library.translate(item.command.with_(at=plain(0.0))).curves:
                yield curve.keys[-1][0] / 1000
