"""Building a `Script` from the events of tags: text grows, places get names, spans open and close."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from difflib import get_close_matches

from mien.core.errors import InputError, Note, unknown_name
from mien.core.limits import check_size
from mien.text.commands import Command, CommandLibrary
from mien.text.intensity import SpanPoint
from mien.text.script import (
    DirectedCommand,
    DirectedCurve,
    DirectedEffort,
    DirectedEmotion,
    Point,
    Prosody,
    Script,
    Segment,
    Spelling,
)
from mien.text.sync_points import Moment
from mien.text.tags import Event, unknown_tag

__all__ = ["SILENT", "Builder", "Element", "OpenEmotion", "Opened"]

SILENT = ("metadata", "meta", "lexicon", "desc")
"""Elements whose text is not spoken."""

PLACED = ("emotion", "effort", "gaze", "mark", "curve", "pose")
"""Elements, besides commands, that have a place between pauses."""


@dataclass
class Opened:
    """An element that is not closed yet."""

    event: Event
    close: Callable[[], None]
    may_stay_open: bool = False
    text_at: int = 0
    segment_at: int = 0
    keys: list[tuple[str, float]] = field(default_factory=list)


@dataclass
class OpenEmotion:
    """An emotion whose element is not closed yet."""

    name: str
    intensity: float
    points: tuple[SpanPoint, ...]
    start: Moment
    goes_on: Moment
    pieces: list[int] = field(default_factory=list)


class Builder:
    """Takes events in order; `finish` gives the script.

    Parameters
    ----------
    library : CommandLibrary
    source : str
        For messages.
    collapse : bool
        Whether blanks and line ends in text are one blank, as in XML documents.
    elements : mapping
        What to do where an element opens, by name.
    """

    def __init__(self, library: CommandLibrary, source: str, collapse: bool, elements: Mapping[str, Element]) -> None:
        self.library, self.source, self.collapse, self.elements = library, source, collapse, elements
        self.segments: list[Segment] = []
        self.text = ""
        self.spellings: list[Spelling] = []
        self.silence: float | None = None
        self.voices: list[str | None] = [None]
        self.points: dict[str, Point] = {}
        self.opened: list[Opened] = []
        self.emotions: list[OpenEmotion] = []
        self.done_emotions: list[DirectedEmotion] = []
        self.efforts: list[DirectedEffort] = []
        self.prosody: list[Prosody] = []
        self.commands: list[DirectedCommand] = []
        self.curves: list[DirectedCurve] = []
        self.gaze: DirectedCommand | None = None
        self.notes: list[str] = []
        self.language: str | None = None
        self.script_voice: str | None = None
        self.line = 1

    # ---- Events ------------------------------------------------------------------------------------------------

    def take(self, event: Event) -> None:
        """Take one event."""
        self.line = event.line
        if event.kind == "text":
            self._say(event.text)
        elif event.kind == "open":
            self._open(event)
            if event.empty:
                self._close(event.text)
        else:
            self._close(event.text)

    def finish(self) -> Script:
        """The script, once all events were taken.

        Raises
        ------
        InputError
            If an element was never closed, or a place is not known.
        """
        while self.opened and self.opened[-1].may_stay_open:
            self.opened.pop()
        if self.opened:
            event = self.opened[-1].event
            raise InputError(
                f"{self.source}, line {event.line}: <{event.text}> is never closed: expected </{event.text}>"
            )
        self.end_segment()
        if self.gaze is not None:
            self.commands.append(replace(self.gaze, until=Moment.at("end")))
        script = Script(
            tuple(self.segments),
            tuple(self.points.values()),
            tuple(self.prosody),
            tuple(self.done_emotions),
            tuple(self.commands),
            tuple(self.curves),
            self.script_voice,
            self.language,
            tuple(Note("note", message) for message in dict.fromkeys(self.notes)),
            tuple(self.efforts),
        )
        _check_points(script, self.source)
        return script

    def _open(self, event: Event) -> None:
        if self.opened and self.opened[-1].event.text == "curve" and event.text != "key":
            raise self.fault(f"<curve> holds <key at= value=/> and nothing else, not <{event.text}>")
        check_size("levels", len(self.opened) + 1, f"{self.source}, line {self.line}")
        self._end_pause(event.text)
        self.opened.append(Opened(event, lambda: None, text_at=len(self.text), segment_at=len(self.segments)))
        if any(item.event.text in SILENT for item in self.opened[:-1]):
            return
        if event.strange:
            self.note(f"<{event.text}>: {', '.join(event.strange)} is of another vocabulary and not followed")
        try:
            if event.foreign or self._is_of_another_standard(event):
                self.note(f"<{event.text}> is not known here; what it holds is spoken as if it were not there")
            elif event.text in self.elements:
                self.elements[event.text](self, self._without_language(event))
            elif event.text in self.library:
                self._command(event)
            else:
                raise unknown_tag(event, (*self.elements, *self.library.names), self.source)
        except InputError as problem:
            raise self._placed(problem) from problem

    @property
    def is_ssml(self) -> bool:
        """Whether this is SSML, where what a voice cannot do is passed over rather than refused."""
        return bool(self.opened) and self.opened[0].event.text == "speak"

    def _is_of_another_standard(self, event: Event) -> bool:
        """Whether SSML holds an element that is none, and is no slip of the pen either."""
        known = (*self.elements, *self.library.names)
        return self.is_ssml and event.text not in known and not get_close_matches(event.text, known, n=1, cutoff=0.75)

    def _without_language(self, event: Event) -> dict[str, str]:
        """Attributes of an element; the language inside the root is told and left out."""
        given = dict(event.attributes)
        if len(self.opened) > 1 and "xml:lang" in given:
            spoken = given.pop("xml:lang")
            if spoken.partition("-")[0].lower() != (self.language or "en").partition("-")[0].lower():
                self.note(f"<{event.text}>: xml:lang={spoken!r} is not followed: the same voice reads it")
            given.pop("onlangfailure", None)
        return given

    def _close(self, name: str) -> None:
        if not any(item.event.text == name for item in self.opened):
            raise self.fault(f"</{name}> closes nothing: no <{name}> is open")
        while self.opened[-1].event.text != name:
            item = self.opened[-1]
            if not item.may_stay_open:
                raise self.fault(
                    f"</{name}> comes before </{item.event.text}>, "
                    f"and <{item.event.text}> of line {item.event.line} is open"
                )
            self.opened.pop()
        if not self.opened[-1].event.empty:
            self._end_pause(name)
        item = self.opened.pop()
        try:
            item.close()
        except InputError as problem:
            raise self._placed(problem) from problem

    # ---- Text and places ---------------------------------------------------------------------------------------

    def _say(self, text: str) -> None:
        if self.opened and self.opened[-1].event.text == "curve":
            if text.strip():
                raise self.fault(f"<curve> holds <key at= value=/> and nothing else, not {text.strip()[:20]!r}")
            return
        if any(item.event.text in SILENT for item in self.opened):
            return
        if self.collapse:
            text = re.sub(r"\s+", " ", text)
            if not self.text or self.text[-1].isspace():
                text = text.lstrip()
        self.text += text

    def end_segment(self) -> None:
        """Close the segment under way, if it has text or a silence of its own."""
        if self.text.strip() or self.silence is not None:
            self.segments.append(Segment(self.text, self.silence, None, self.voices[-1], tuple(self.spellings)))
            self.text, self.silence, self.spellings = "", None, []
        elif self.text:  # blanks only: points in it would dangle
            self.text = ""

    def _end_pause(self, element: str) -> None:
        """A pause before a place is a segment of its own, so that the place lies after it, whatever follows."""
        if self.silence is not None and not self.text.strip() and (element in PLACED or element in self.library):
            self.end_segment()

    def point(self, after: bool = False, name: str | None = None) -> Moment:
        """Name the place where the text stands now."""
        if name is None:
            name = f"_{len(self.points) + 1}"
        elif name in self.points:
            raise InputError(f"mark {name!r} stands there twice")
        elif not re.fullmatch(r"[A-Za-z_][\w:-]*", name):
            raise InputError(f"a mark's name is a word such as m1, not {name!r}")
        self.points[name] = Point(name, len(self.segments), len(self.text), after)
        return Moment.at(name)

    def said_in(self, item: Opened) -> bool:
        """Whether there was text since an element opened."""
        return len(self.segments) > item.segment_at or len(self.text) > item.text_at

    def start_in(self, item: Opened) -> int:
        """Where in the segment under way the text of an element begins."""
        return item.text_at if len(self.segments) == item.segment_at else 0

    def fault(self, message: str) -> InputError:
        """An error at the line where the events stand."""
        return InputError(f"{self.source}, line {self.line}: {message}")

    def note(self, message: str) -> None:
        """Something that could not be done as asked."""
        self.notes.append(f"{self.source}, line {self.line}: {message}")

    def _placed(self, problem: InputError) -> InputError:
        return problem if str(problem).startswith(f"{self.source}, line") else self.fault(str(problem))

    # ---- Commands ----------------------------------------------------------------------------------------------

    def _command(self, event: Event) -> None:
        given = dict(event.attributes)
        until = given.pop("until", None)
        here = self.point()
        at = Moment.parse(given.pop("at"), here.terms[0][0]) if "at" in given else here
        command = Command(event.text, tuple(given.items()), f"{self.source}, line {event.line}")
        self.library.check(command.with_(at="0") if "at" in self.library[event.text].parameters else command)
        item, place = self.opened[-1], len(self.commands)
        self.commands.append(DirectedCommand(command, at, Moment.parse(until, here.terms[0][0]) if until else None))
        item.may_stay_open = True

        def close() -> None:
            if until is None and self.said_in(item):
                self.commands[place] = replace(self.commands[place], until=self.point(after=True))

        item.close = close

    def add_command(self, name: str, at: Moment, until: Moment | None, **given: str) -> None:
        """A command that another element stands for."""
        command = Command(name, tuple(given.items()), f"{self.source}, line {self.line}")
        self.library.check(command.with_(at="0"))
        self.commands.append(DirectedCommand(command, at, until))


def _check_points(script: Script, source: str) -> None:
    known = {point.name for point in script.points} | {"start", "end"}
    moments = [moment for item in script.commands for moment in (item.at, item.until) if moment]
    moments += [key for curve in script.curves for key, _ in curve.keys]
    moments += [segment.start for segment in script.segments if segment.start]
    for moment in moments:
        for term, _ in moment.terms:
            name = term.partition(".")[0]
            if name not in known:
                marks = [point for point in known if not point.startswith("_")]
                raise InputError(f"{source}: {unknown_name('mark', name, marks)}")


Element = Callable[[Builder, dict[str, str]], None]
"""What to do where an element opens; its attributes are given."""
