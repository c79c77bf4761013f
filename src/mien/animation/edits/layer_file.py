"""``mien-edits``: a layer of edits as JSON, for files and for the studio (``docs/edits.md``)."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, NoReturn, TypeVar, cast

from mien.animation.edits.edited_line import Line, LineWord
from mien.animation.edits.layer import Anchor, BorderEdit, ChannelEdit, Edit, EditLayer, IntensityEdit, Place, Points
from mien.core.border import guarded
from mien.core.errors import InputError
from mien.core.files import replace_when_complete
from mien.core.plain_text import parsed_json, read_plain_text
from mien.text.key_tangents import TANGENTS

__all__ = ["FORMAT", "VERSION", "layer_of", "plain_layer", "plain_line", "read_layer", "write_layer"]

FORMAT, VERSION = "mien-edits", 1
Made = TypeVar("Made")


@guarded("edits")
def read_layer(path: str | Path) -> EditLayer:
    """Read a layer from a file.

    Raises
    ------
    InputError
        If it cannot be read or does not hold together; the message names the file and the place in it.

    Examples
    --------
    >>> read_layer("nowhere.json")
    Traceback (most recent call last):
    mien.core.errors.InputError: nowhere.json: no such file
    """
    text, _ = read_plain_text(path, f"a {FORMAT} file")
    try:
        document = parsed_json(text, parse_constant=_refuse_constant)
    except ValueError as problem:
        raise InputError(f"{path} is not a {FORMAT} file: {problem}") from problem
    return layer_of(document, str(path))


def write_layer(layer: EditLayer, path: str | Path) -> None:
    """Write a layer so that `read_layer` gives back an equal one.

    Raises
    ------
    OutputError
        If the file cannot be written.
    """
    with replace_when_complete(path) as unfinished:
        unfinished.write_text(json.dumps(plain_layer(layer), ensure_ascii=False, indent=1) + "\n", encoding="utf-8")


# ---------------------------------------------------------------- writing


def plain_layer(layer: EditLayer) -> dict[str, Any]:
    """A layer as JSON.

    Examples
    --------
    >>> plain_layer(EditLayer((BorderEdit(Place("never", 1, 2), "end", 0.03),)))["edits"]
    [{'kind': 'border', 'phone': {'word': 'never', 'occurrence': 1, 'phone': 2}, 'edge': 'end', 'shift': 0.03}]
    """
    told: dict[str, Any] = {"format": FORMAT, "version": VERSION}
    if layer.line is not None:
        told["line"] = plain_line(layer.line)
    if layer.emotions is not None:
        told["emotions"] = list(layer.emotions)
    return told | {"edits": [_plain_edit(edit) for edit in layer.edits]}


def plain_line(line: Line) -> list[dict[str, Any]]:
    """The words of a line as JSON."""
    return [{"word": word.word, "phones": list(word.phones), "pauses": list(word.pauses)} for word in line]


def _plain_edit(edit: Edit) -> dict[str, Any]:
    if isinstance(edit, BorderEdit):
        return {"kind": "border", "phone": _plain_place(edit.phone), "edge": edit.edge, "shift": edit.shift}
    if isinstance(edit, IntensityEdit):
        points = _plain_points(edit.points, edit.tangents)
        return {"kind": "intensity", "emotion": edit.emotion, "interpolation": edit.interpolation, "points": points}
    return {
        "kind": "channel",
        "channel": edit.channel,
        "mode": edit.mode,
        "fade": edit.fade,
        "interpolation": edit.interpolation,
        "keys": _plain_points(edit.keys, edit.tangents),
    }


def _plain_place(place: Place) -> dict[str, Any]:
    number = {"pause" if place.pause else "phone": place.index}
    return {"word": place.word, **({} if place.word is None else {"occurrence": place.occurrence}), **number}


def _plain_points(points: Points, tangents: tuple[str | None, ...]) -> list[dict[str, Any]]:
    told: list[dict[str, Any]] = [
        {"anchor": {**_plain_place(a.place), "share": a.share}, "value": value} for a, value in points
    ]
    for point, tangent in zip(told, tangents, strict=False):  # empty: none has one
        point |= {} if tangent is None else {"tangent": tangent}
    return told


# ---------------------------------------------------------------- reading


def layer_of(document: Any, source: str = "the layer") -> EditLayer:
    """Read a layer from JSON that is loaded already.

    Raises
    ------
    InputError
        If it does not hold together; the message names the place, such as ``edits[2].keys[0].value``.

    Examples
    --------
    >>> layer_of({"format": "mien-edits", "version": 1, "edits": [{"kind": "bend"}]})
    Traceback (most recent call last):
    mien.core.errors.InputError: the layer, edits[0].kind: expected one of border, intensity, channel, got 'bend'
    """
    node = _Node(document, source, "")
    if not isinstance(document, dict) or document.get("format") != FORMAT:
        raise node.fault(f'expected an object with "format": "{FORMAT}"')
    if document.get("version") != VERSION:
        raise node.fault(f"this mien reads version {VERSION}, got {str(document.get('version'))[:20]}")
    node.only("format", "version", "line", "emotions", "edits")
    line = tuple(_word(word) for word in node.get("line").items()) if node.holds("line") else None
    if line is not None and (not line or line[0].word is not None or any(word.word is None for word in line[1:])):
        raise node.get("line").fault("its first entry, and no other, has the word null")
    emotions = tuple(name.text() for name in node.get("emotions").items()) if node.holds("emotions") else None
    return EditLayer(tuple(_edit(edit) for edit in node.get("edits").items()), line, emotions)


def _word(node: _Node) -> LineWord:
    node.only("word", "phones", "pauses")
    word = None if node.get("word").value is None else node.get("word").text()
    phones, pauses = (tuple(n.text() for n in node.get(key).items()) if node.holds(key) else () for key in
                      ("phones", "pauses"))  # fmt: skip
    return LineWord(word, phones, pauses)


def _edit(node: _Node) -> Edit:
    return _KINDS[node.get("kind").one_of(*_KINDS)](node)


def _border(node: _Node) -> Edit:
    node.only("kind", "phone", "edge", "shift")
    edge = cast(Any, node.get("edge").one_of("start", "end"))
    return node.made(BorderEdit, _place(node.get("phone"), ()), edge, node.get("shift").number())


def _intensity(node: _Node) -> Edit:
    node.only("kind", "emotion", "interpolation", "points")
    how = node.get("interpolation").text() if node.holds("interpolation") else "linear"
    points = node.get("points")
    return node.made(IntensityEdit, node.get("emotion").text(), _points(points), how, _tangents(points))


def _channel(node: _Node) -> Edit:
    node.only("kind", "channel", "mode", "keys", "fade", "interpolation")
    fade = node.get("fade").number() if node.holds("fade") else 0.1
    how = node.get("interpolation").text() if node.holds("interpolation") else "smooth"
    mode = node.get("mode").one_of("add", "replace")
    keys = node.get("keys")
    return node.made(ChannelEdit, node.get("channel").text(), mode, _points(keys), fade, how, _tangents(keys))


_KINDS: dict[str, Callable[[_Node], Edit]] = {"border": _border, "intensity": _intensity, "channel": _channel}


def _points(node: _Node) -> Points:
    return tuple(_point(point) for point in node.items())


def _tangents(node: _Node) -> tuple[str | None, ...]:
    found = tuple(p.get("tangent").one_of(*TANGENTS) if p.holds("tangent") else None for p in node.items())
    return found if any(found) else ()


def _point(node: _Node) -> tuple[Anchor, float]:
    node.only("anchor", "value", "tangent")
    anchor = node.get("anchor")
    share = anchor.get("share").number() if anchor.holds("share") else 0.0
    return anchor.made(Anchor, _place(anchor, ("share",)), share), node.get("value").number()


def _place(node: _Node, besides: Sequence[str]) -> Place:
    node.only("word", "occurrence", "phone", "pause", *besides)
    word = None if node.get("word").value is None else node.get("word").text()
    if node.holds("phone") == node.holds("pause"):
        raise node.fault("expected one of 'phone' and 'pause': their number, from 0")
    which = "pause" if node.holds("pause") else "phone"
    occurrence = node.get("occurrence").whole() if node.holds("occurrence") else 1
    return node.made(Place, word, occurrence, node.get(which).whole(), which == "pause")


class _Node:
    """A value of the document that knows where it stands, so that every fault can name its place."""

    def __init__(self, value: Any, source: str, place: str) -> None:
        self.value, self.source, self.place = value, source, place

    def fault(self, message: str) -> InputError:
        return InputError(f"{self.source}, {self.place}: {message}" if self.place else f"{self.source}: {message}")

    def only(self, *known: str) -> None:
        """Refuse fields that mean nothing: they are misspelt, or of a later version."""
        if not isinstance(self.value, dict):
            raise self.fault(f"expected an object, got {_kind(self.value)}")
        for name in self.value:
            if name not in known:
                raise self.fault(f"unknown field {str(name)[:40]!r}; known: {', '.join(known)}")

    def holds(self, name: str) -> bool:
        return isinstance(self.value, dict) and self.value.get(name) is not None

    def get(self, name: str) -> _Node:
        if not isinstance(self.value, dict) or name not in self.value:
            raise self.fault(f"the field {name!r} is missing")
        return _Node(self.value[name], self.source, f"{self.place}.{name}" if self.place else name)

    def items(self) -> list[_Node]:
        if not isinstance(self.value, list):
            raise self.fault(f"expected a list, got {_kind(self.value)}")
        return [_Node(item, self.source, f"{self.place}[{number}]") for number, item in enumerate(self.value)]

    def text(self) -> str:
        if not isinstance(self.value, str) or len(self.value) > 200:
            raise self.fault(f"expected a text, got {_kind(self.value)}")
        return self.value

    def number(self) -> float:
        if isinstance(self.value, bool) or not isinstance(self.value, (int, float)):
            raise self.fault(f"expected a number, got {_kind(self.value)}")
        if abs(self.value) > 1e9 or not math.isfinite(self.value):
            raise self.fault("expected a number of sensible size")
        return float(self.value)

    def whole(self) -> int:
        if isinstance(self.value, bool) or not isinstance(self.value, int) or abs(self.value) > 10**6:
            raise self.fault(f"expected a whole number, got {_kind(self.value)}")
        return self.value

    def one_of(self, *known: str) -> str:
        if not isinstance(self.value, str) or self.value not in known:
            raise self.fault(f"expected one of {', '.join(known)}, got {_kind(self.value)}")
        return self.value

    def made(self, what: Callable[..., Made], *parts: Any) -> Made:
        """Make something of the parts; what it refuses is told with the place."""
        try:
            return what(*parts)
        except InputError as problem:
            raise self.fault(str(problem)) from problem


def _kind(value: Any) -> str:
    names = {dict: "an object", list: "a list", bool: "true or false", type(None): "null"}
    return names.get(type(value), repr(value)[:60])


def _refuse_constant(name: str) -> NoReturn:
    raise ValueError(f"{name} is not JSON")
