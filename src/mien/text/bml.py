"""BML 1.0 to a `Script`: speech with its sync points, head, gaze and face (``docs/script.md`` has the table).

Every sync point of every behaviour becomes a moment: where it is given, what it refers to; else between the given ones
by the usual shares of such a behaviour. What has no place on a talking head (gestures, posture, locomotion) is a note.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from difflib import get_close_matches
from functools import cache
from typing import Any

from mien.core.assets import asset_table
from mien.core.errors import InputError, Note, unknown_name
from mien.core.limits import is_whole
from mien.text.commands import Command, CommandLibrary
from mien.text.face_parameters import face_parameter
from mien.text.script import DirectedCommand, DirectedCurve, Point, Script, Segment
from mien.text.script_builder import Builder
from mien.text.sync_points import Moment
from mien.text.tag_elements import ELEMENTS, gaze_targets
from mien.text.tags import Event

__all__ = ["read_bml"]

_REFERENCE = re.compile(r"\s*([\w.-]+?(?::[\w.-]+?){1,3})\s*(?:([+-])\s*(\d+(?:\.\d*)?|\.\d+)\s*)?$")
_HEADS = ("head", "headDirectionShift")
_GAZES = ("gaze", "gazeShift")
_FACES = ("faceLexeme", "faceFacs", "faceShift", "face")
_KIND = (
    {"speech": "speech"} | dict.fromkeys(_HEADS, "head") | dict.fromkeys(_GAZES, "gaze") | dict.fromkeys(_FACES, "face")
)
_NOT_HERE = ("gesture", "pointing", "posture", "postureShift", "pose", "locomotion", "wait", "emit", "object")
"""What has no place on a head. Their sync points are kept, so that what refers to them keeps its time."""
_KIND |= dict.fromkeys(_NOT_HERE, "unseen")
_GIVEN = {
    "speech": (),
    "head": ("lexeme", "type", "repetition", "amount", "target", "offsetAngle", "offsetDirection"),
    "gaze": ("target", "influence", "offsetAngle", "offsetDirection"),
    "face": ("lexeme", "amount", "au", "side"),
}
"""Attributes of behaviours, besides id and sync points."""


_REQUIRED = ", although it is required; the rest is performed"


@dataclass
class _Element:
    name: str
    given: dict[str, str]
    line: int
    children: list[_Element | str] = field(default_factory=list)

    def elements(self) -> Iterator[_Element]:
        return (child for child in self.children if isinstance(child, _Element))

    def text(self) -> str:
        return "".join(child if isinstance(child, str) else child.text() for child in self.children)


def read_bml(events: Sequence[Event], library: CommandLibrary, source: str) -> Script:
    """Read a BML block.

    Raises
    ------
    InputError
        If a reference names no behaviour or sync point, references run in a circle, or a value does not fit.
    """
    return _Block(_tree(events), library, source).script()


def _tree(events: Sequence[Event]) -> _Element:
    root = _Element("", {}, 1)
    stack = [root]
    for event in events:
        if event.kind == "open":
            given = dict(event.attributes) | dict.fromkeys(event.strange, "...")
            stack.append(_Element(event.text, given, event.line))
            stack[-2].children.append(stack[-1])
        elif event.kind == "close":
            stack.pop()
        else:
            stack[-1].children.append(event.text)
    return next(root.elements())


@cache
def _table() -> dict[str, Any]:
    return asset_table("performance/bml.toml")


class _Block:
    """One ``<bml>`` element."""

    def __init__(self, root: _Element, library: CommandLibrary, source: str) -> None:
        self.library, self.source = library, source
        self.behaviours: dict[str, _Element] = {}
        self.sync: dict[str, dict[str, str]] = {}
        self.solved: dict[tuple[str, str], Moment] = {}
        self.solving: list[tuple[str, str]] = []
        self.notes: list[str] = []
        self.segments: list[Segment] = []
        self.points: dict[str, Point] = {}
        self.commands: list[DirectedCommand] = []
        self.curves: list[DirectedCurve] = []
        self.name = root.given.get("id", "")
        for name, value in root.given.items():
            if name in ("composition", "characterId", "character") and value != "MERGE":
                self.note(root, f"{name}={value!r} is not followed: there is one block and one face")
            elif name not in ("id", "xml:id", "composition", "characterId", "character"):
                self.note(root, f"{name}={value!r} is not followed")
        for element in root.elements():
            self._gather(element)

    def note(self, element: _Element, message: str) -> None:
        self.notes.append(f"{self.source}, line {element.line}: {message}")

    def fault(self, element: _Element, message: str) -> InputError:
        return InputError(f"{self.source}, line {element.line}: {message}")

    def _gather(self, element: _Element, required: bool = False) -> None:
        if element.name == "required":
            for child in element.elements():
                self._gather(child, required=True)
        elif element.name == "constraint":
            self._constrain(element)
        elif element.name in _KIND:
            self._behaviour(element, required)
        else:
            self.note(element, f"<{element.name}> is not known and left out" + _REQUIRED * required)

    def _behaviour(self, element: _Element, required: bool) -> None:
        name = element.given.get("id") or f"{element.name}{len(self.behaviours) + 1}"
        if name in self.behaviours:
            raise self.fault(element, f"the id {name!r} stands there twice")
        self.behaviours[name] = element
        known, kind = self._shares(element), _KIND[element.name]
        given = self.sync.setdefault(name, {})
        given |= {key: value for key, value in element.given.items() if key in known}
        if element.name == "wait":
            self._wait(element)
        if kind == "unseen":
            self.note(element, f"<{element.name}> cannot be shown by a head and is left out" + _REQUIRED * required)
            return
        for key, value in element.given.items():
            if key not in (*known, *_GIVEN[kind], "id", "xml:id"):
                self.note(element, f"<{element.name}>: {key}={value!r} is not followed")

    def _constrain(self, element: _Element) -> None:
        for relation in element.elements():
            if relation.name not in ("synchronize", "before", "after"):
                self.note(relation, f"the constraint <{relation.name}> is not followed")
                continue
            followers = list(relation.elements())
            anchor = relation.given.get("ref") or (followers.pop(0).given.get("ref") if followers else None)
            if anchor is None:
                raise self.fault(relation, f'<{relation.name}> needs ref="behaviour:point"')
            for follower in followers:
                self._follow(follower, anchor)

    def _follow(self, follower: _Element, anchor: str) -> None:
        found = self._parsed(follower, follower.given.get("ref", ""))
        if found is None:
            raise self.fault(follower, f'expected <sync ref="behaviour:point"/>, got {follower.given.get("ref")!r}')
        name, point, offset = found
        given = self.sync.setdefault(name, {})
        if point in given:
            self.note(follower, f"{name}:{point} has a time already; the constraint is left out")
        elif not offset:
            given[point] = anchor
        else:  # follower + offset stands at the anchor
            whole = _REFERENCE.match(anchor)
            before = float(f"{whole[2]}{whole[3]}") if whole and whole[2] else 0.0
            total = before - offset / 1000
            given[point] = (whole[1] if whole else anchor) + (f"{total:+g}" if total else "")

    def _parsed(self, element: _Element, text: str) -> tuple[str, str, float] | None:
        """Behaviour, sync point and offset in ms of ``behaviour:point+seconds``; block and repetition are told."""
        found = _REFERENCE.match(text)
        if found is None:
            return None
        parts, offset = found[1].split(":"), float(f"{found[2]}{found[3]}") if found[2] else 0.0
        whole = text.strip().split(":")
        if whole[-2] in self.behaviours and whole[-1] in self._points_of(whole[-2]):
            parts, offset = whole, 0.0  # a name such as sync-1
        if len(parts) > 2 and is_whole(parts[-1]):
            if parts[-1] != "1":
                self.note(element, f"{text!r}: the repetition {parts[-1]} cannot be selected; the first is used")
            parts = parts[:-1]
        if len(parts) == 3:
            if self.name and parts[0] != self.name:
                self.note(element, f"{text!r}: there is no other block; {':'.join(parts[1:])} of this one is taken")
            parts = parts[1:]
        if len(parts) != 2:
            return None
        return parts[0], parts[1], 1000 * offset

    # ---- Time --------------------------------------------------------------------------------------------------

    def _shares(self, element: _Element) -> dict[str, float]:
        if element.name == "speech":
            return {"start": 0.0, "end": 1.0}
        shares: dict[str, float] = _table()[_KIND[element.name]]["share"]
        return shares

    def moment(self, name: str, point: str) -> Moment:
        """When a sync point of a behaviour is reached."""
        key = (name, point)
        if key in self.solved:
            return self.solved[key]
        element = self.behaviours[name]
        if key in self.solving:
            circle = " -> ".join(":".join(item) for item in (*self.solving[self.solving.index(key) :], key))
            raise self.fault(element, f"sync points refer to one another in a circle: {circle}")
        self.solving.append(key)
        try:
            self.solved[key] = self._solve(name, point)
        finally:
            self.solving.pop()
        return self.solved[key]

    def _solve(self, name: str, point: str) -> Moment:
        element, given = self.behaviours[name], self.sync[name]
        if element.name == "speech":
            return Moment.at(_safe(f"{name}:{point}"))
        if point in given:
            return self._refer(element, given[point])
        shares, length = self._shares(element), self._length(element)
        share = shares[point]
        known = sorted((shares[other], other) for other in given if other in shares)
        before = [item for item in known if item[0] <= share]
        after = [item for item in known if item[0] > share]
        if before and after:
            low, high = before[-1], after[0]
            part = (share - low[0]) / (high[0] - low[0])
            return self.moment(name, low[1]).towards(self.moment(name, high[1]), part)
        if before:
            return self.moment(name, before[-1][1]) + (share - before[-1][0]) * length
        if after:
            return self.moment(name, after[0][1]) + (share - after[0][0]) * length
        return Moment(offset=share * length)

    def _length(self, element: _Element) -> float:
        seconds: float = _table()[_KIND[element.name]]["seconds"]
        if element.name == "wait":
            seconds = self._wait(element)
        return 1000 * seconds * (self._repetition(element) if element.name == "head" else 1)

    def _wait(self, element: _Element) -> float:
        """Seconds that a ``<wait>`` says it lasts; 0 where it waits for an event."""
        text = element.given.get("duration") or element.given.get("max-wait") or "0"
        if re.fullmatch(r"\d+(\.\d*)?|\.\d+", text) is None:
            raise self.fault(element, f"duration is seconds, not {text!r}")
        return float(text)

    def _refer(self, element: _Element, text: str) -> Moment:
        if re.fullmatch(r"\s*\+?(\d+(\.\d*)?|\.\d+)\s*", text):
            return Moment(offset=round(float(text) * 1000, 6))
        found = self._parsed(element, text)
        if found is None:
            raise self.fault(element, f"a sync reference is seconds, or behaviour:point+seconds, not {text!r}")
        name, point, offset = found
        if name == self.name and name not in self.behaviours and point in ("start", "end"):
            return Moment(offset=offset) if point == "start" else Moment.at("end") + offset
        if name not in self.behaviours:
            raise self.fault(element, str(unknown_name("behaviour", name, self.behaviours)))
        known = self._points_of(name)
        if point not in known:
            raise self.fault(element, str(unknown_name(f"sync point of {name}", point, known)))
        return self.moment(name, point) + offset

    def _points_of(self, name: str) -> list[str]:
        element = self.behaviours[name]
        marks = [sync.given.get("id", "") for sync in _inside(element, ("sync", "mark"))]
        marks += [sync.given.get("name", "") for sync in _inside(element, ("mark",))]
        return [*self._shares(element), *filter(None, marks)]

    # ---- Behaviours --------------------------------------------------------------------------------------------

    def script(self) -> Script:
        for name, element in self.behaviours.items():
            if element.name == "speech":
                self._speech(name, element)
        for name, element in self.behaviours.items():
            if _KIND[element.name] not in ("speech", "unseen"):
                {"head": self._head, "gaze": self._gaze, "face": self._face}[_KIND[element.name]](name, element)
        for name in self.sync:
            if name not in self.behaviours:
                raise InputError(f"{self.source}: {unknown_name('behaviour in a constraint', name, self.behaviours)}")
        return Script(
            tuple(self.segments),
            tuple(self.points.values()),
            commands=tuple(self.commands),
            curves=tuple(self.curves),
            notes=tuple(Note("note", message) for message in dict.fromkeys(self.notes)),
        )

    def _speech(self, name: str, element: _Element) -> None:
        plain = any(child.name == "text" for child in element.elements())
        if plain and any(child.name == "description" for child in element.elements()):
            self.note(element, "<description> is left out: the plain <text> is spoken")
        if "end" in self.sync[name]:
            self.note(element, f"the end of {name} is where its words end; the one given is not followed")
        texts = [child for child in element.elements() if child.name == "text"]
        texts = texts or list(_inside(element, ("speak",))) or [element]
        builder = Builder(self.library, self.source, collapse=True, elements=ELEMENTS)
        for child in texts[0].children:
            self._feed(builder, child)
        read = builder.finish()
        if read.commands or read.curves or read.emotions or read.prosody:
            self.note(element, "commands and prosody inside <text> are ignored: give them as behaviours")
        spoken = [segment for segment in read.segments if segment.text.strip()]
        if not spoken:
            raise self.fault(element, f"the speech {name!r} has no text: <speech><text>…</text></speech>")
        first = len(self.segments)
        start = self._refer(element, self.sync[name]["start"]) if "start" in self.sync[name] else None
        if start is None and any(segment.text for segment in self.segments):
            self.note(element, f"{name} has no start; it follows the speech before it")
        self.segments.append(replace(read.segments[0], start=start))
        self.segments += read.segments[1:]
        for point in read.points:
            point_name = point.name if point.name.startswith("_") else f"{name}:{point.name}"
            unique = _safe(f"{name}:{point.name}" if point.name.startswith("_") else point_name)
            self.points[unique] = Point(unique, point.segment + first, point.place, point.after)
        last = len(self.segments) - 1
        for unique, segment, place, after in (
            (_safe(f"{name}:start"), first, 0, False),
            (_safe(f"{name}:end"), last, len(self.segments[last].text), True),
        ):
            self.points[unique] = Point(unique, segment, place, after)

    def _feed(self, builder: Builder, child: _Element | str) -> None:
        if isinstance(child, str):
            builder.take(Event("text", child, builder.line))
            return
        if child.name == "sync":
            given = (("name", _safe(child.given.get("id", ""))),)
            builder.take(Event("open", "mark", child.line, given))
            builder.take(Event("close", "mark", child.line))
            return
        builder.take(Event("open", child.name, child.line, tuple(child.given.items())))
        for inner in child.children:
            self._feed(builder, inner)
        builder.take(Event("close", child.name, child.line))

    def _repetition(self, element: _Element) -> int:
        text = element.given.get("repetition", "1").strip().removesuffix(".0")
        if not is_whole(text) or int(text) < 1:
            raise self.fault(element, f"repetition is a whole number, 1 or more, not {text!r}")
        return int(text)

    def _amount(self, element: _Element, default: float = 0.5) -> float:
        try:
            amount = float(element.given.get("amount", default))
        except ValueError:
            amount = -1.0
        if not 0 <= amount <= 1:
            raise self.fault(element, f"amount runs from 0 to 1, not {element.given['amount']!r}")
        return amount

    def _lexeme(self, element: _Element, kind: str) -> str | None:
        """A command, or an action unit; None (and a note) for a lexeme of another set."""
        lexeme = (element.given.get("lexeme") or element.given.get("type") or "").strip()
        known: dict[str, str] = _table()[kind]["lexemes"]
        sign = lexeme.upper().replace("-", "_")
        if sign in known:
            return known[sign]
        if lexeme in self.library:
            return lexeme
        if not lexeme:
            raise self.fault(element, f"<{element.name}> needs lexeme=, one of {', '.join(known)}")
        if get_close_matches(sign, known, n=1) or get_close_matches(lexeme, self.library.names, n=1):
            raise self.fault(
                element, str(unknown_name(f"lexeme of <{element.name}>", lexeme, [*known, *self.library.names]))
            )
        self.note(element, f"the lexeme {lexeme!r} is not known and left out; known: {', '.join(known)}")
        return None

    def _head(self, name: str, element: _Element) -> None:
        if element.name == "headDirectionShift":
            yaw, pitch = self._target(element)
            start, end = self.moment(name, "start"), self.moment(name, "end")
            for parameter, degrees in (("HeadTurn", yaw), ("HeadNod", -pitch)):
                self._curve(element, parameter, ((start, 0.0), (end, degrees / 60), (Moment.at("end"), degrees / 60)))
            return
        command = self._lexeme(element, "head")
        if command is None:
            return
        percent = self._amount(element) * _table()["head"]["percent"]
        given = [("amplitude", f"{percent:g}")]
        if "count" in self.library[command].parameters:
            given.append(("count", str(self._repetition(element))))
        directed = Command(command, tuple(given), f"{self.source}, line {element.line}")
        self.library.check(directed.with_(at="0"))
        self.commands.append(DirectedCommand(directed, self.moment(name, "start"), self.moment(name, "end")))

    def _gaze(self, name: str, element: _Element) -> None:
        yaw, pitch = self._target(element)
        start = self.moment(name, "start")
        end = Moment.at("end") if element.name == "gazeShift" else self.moment(name, "end")
        influence = element.given.get("influence", "EYES").upper()
        if influence not in ("EYES", "HEAD", "NECK"):
            self.note(element, f"influence={influence!r}: eyes and head turn, nothing else")
        head_share = 0.0 if influence == "EYES" else 0.7
        where = f"{self.source}, line {element.line}"
        eyes = (("yaw", f"{yaw * (1 - head_share):g}"), ("pitch", f"{pitch * (1 - head_share):g}"))
        self.commands.append(DirectedCommand(Command("LookAt", eyes, where), start, end))
        if head_share:
            ready, relax = (
                self.moment(name, "ready"),
                end if element.name == "gazeShift" else self.moment(name, "relax"),
            )
            for parameter, degrees in (("HeadTurn", yaw), ("HeadNod", -pitch)):
                value = degrees * head_share / 60
                self._curve(element, parameter, ((start, 0.0), (ready, value), (relax, value), (end, 0.0)))

    def _target(self, element: _Element) -> tuple[float, float]:
        target = element.given.get("target", "camera")
        yaw, pitch = gaze_targets().get(target.lower(), (0.0, 0.0))
        if target.lower() not in gaze_targets():
            self.note(element, f"nothing called {target!r} is in the scene: the face looks at the camera")
        try:
            angle = float(element.given.get("offsetAngle", 0))
        except ValueError:
            raise self.fault(element, f"offsetAngle is degrees, not {element.given['offsetAngle']!r}") from None
        way = element.given.get("offsetDirection", "RIGHT").upper()
        if way not in _table()["offsets"]:
            raise self.fault(element, str(unknown_name("offsetDirection", way, _table()["offsets"])))
        side, height = _table()["offsets"][way]
        return yaw + angle * side, pitch + angle * height

    def _face(self, name: str, element: _Element) -> None:
        parts = [item for item in element.elements() if item.name in _FACES]
        for item in element.elements():
            if item.name not in _FACES:
                self.note(item, f"<{item.name}> in <{element.name}> is left out")
        parts = parts or [element]
        for part in parts:
            for parameter, value in self._shape(part).items():
                start, end = self.moment(name, "start"), self.moment(name, "end")
                peak, relax = self.moment(name, "attackPeak"), self.moment(name, "relax")
                if element.name == "faceShift":
                    keys: tuple[tuple[Moment, float], ...] = ((start, 0.0), (end, value), (Moment.at("end"), value))
                else:
                    keys = ((start, 0.0), (peak, value), (relax, value), (end, 0.0))
                self._curve(part, parameter, keys)

    def _shape(self, element: _Element) -> dict[str, float]:
        """Face parameters at the peak."""
        if "au" in element.given:
            return self._units(element)
        if element.name == "faceFacs":
            raise self.fault(element, "<faceFacs> needs au=, the number of an action unit")
        lexeme = self._lexeme(element, "face")
        if lexeme is None:
            return {}
        if lexeme.startswith("AU"):
            return {lexeme: self._amount(element)}
        command = self.library[lexeme]
        scale = self._amount(element) * _table()["face"]["percent"] / 100
        return {
            parameter: max((key.factor for key in keys if key.of is None), key=abs, default=0.0) * scale
            for parameter, keys in command.lists.items()
        }

    def _units(self, element: _Element) -> dict[str, float]:
        number, side = element.given["au"].upper().removeprefix("AU"), element.given.get("side", "BOTH").upper()
        if side not in ("BOTH", "LEFT", "RIGHT"):
            raise self.fault(element, str(unknown_name("side", side, ("BOTH", "LEFT", "RIGHT"))))
        name = f"AU{number}" + ("" if side == "BOTH" else side[0])
        try:
            face_parameter(name)
        except InputError as problem:
            raise self.fault(
                element, f"{name} is no action unit of this face ({str(problem).partition(':')[0]})"
            ) from problem
        return {name: self._amount(element)}

    def _curve(self, element: _Element, parameter: str, keys: tuple[tuple[Moment, float], ...]) -> None:
        where = f"{self.source}, line {element.line}"
        self.curves.append(DirectedCurve(parameter, keys, "smooth", where=where))


def _inside(element: _Element, names: tuple[str, ...]) -> Iterator[_Element]:
    for child in element.elements():
        if child.name in names:
            yield child
        yield from _inside(child, names)


def _safe(name: str) -> str:
    return re.sub(r"[^\w:]", "_", name)
