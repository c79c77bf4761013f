"""When the points of a script are reached once its words have times, and what it asks for in those times."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from itertools import pairwise
from typing import TypeVar

from mien.core.errors import InputError, Note
from mien.core.limits import is_whole
from mien.core.timeline import Interval
from mien.core.utterance import PAUSE
from mien.pipeline.spoken import Spoken
from mien.pipeline.spoken_joining import Joined
from mien.text.commands import Command, CommandLibrary, shipped_library
from mien.text.effort_spans import EffortCurve, EffortSpan
from mien.text.intensity import IntensityCurve
from mien.text.parameter_curves import ParameterCurve
from mien.text.score import EmotionSpan
from mien.text.script import DirectedCommand, DirectedCurve, DirectedEffort, DirectedEmotion, Point, Script, Segment
from mien.text.sync_points import Moment, plain

__all__ = ["Clock", "emotions_at", "naming_its_line", "place"]

_EARLY = 1000.0  # ms before the sound at which a command may begin
Result = TypeVar("Result")


class Clock:
    """Milliseconds of points, and of what is looked for from a point on.

    Parameters
    ----------
    joined : Joined
    points : sequence of Point
    segments : sequence of Segment
        Their pauses tell when a point that no word follows is reached.
    """

    def __init__(self, joined: Joined, points: Sequence[Point], segments: Sequence[Segment] = ()) -> None:
        self.segments = segments
        self.words = joined.utterance.words.intervals
        self.phones = joined.utterance.phones.intervals
        self.duration = joined.utterance.duration
        self.places = joined.places
        self.points = {point.name: point for point in points}

    def time_of(self, reference: str) -> float:
        """Milliseconds of a point such as ``m1``, ``m1.word.2.end``, ``start``, ``end``.

        Raises
        ------
        InputError
            If there is no such point, word or phone.
        """
        name, _, selector = reference.partition(".")
        if name in ("start", "end") and name not in self.points:
            if selector and name == "end":
                raise InputError(f"nothing is said after the end: {reference!r}")
            seconds, following = (0.0, 0) if name == "start" else (self.duration, len(self.words))
        elif name in self.points:
            seconds, following = self._reached(self.points[name])
        else:
            raise InputError(f"there is no mark {name!r}")
        if selector:
            seconds = self._selected(selector.split("."), following, reference)
        return round(seconds * 1000, 3)

    def _reached(self, point: Point) -> tuple[float, int]:
        """Seconds of a point, and the number of the word that follows it."""
        before = 0
        for number, place in enumerate(self.places):
            inside = place.segment == point.segment
            limit = place.start < point.place if point.after else place.end <= point.place
            if place.segment < point.segment or (inside and limit):
                before = number + 1
        same = before < len(self.places) and self.places[before].segment == point.segment
        if not point.after and same:
            return self.words[before].start, before
        return self._after_pauses(point, before), before

    def _after_pauses(self, point: Point, before: int) -> float:
        """Seconds of a point that no word follows in its segment: after the last word, and the pauses since."""
        last, segment = (self.words[before - 1].end, self.places[before - 1].segment) if before else (0.0, -1)
        pauses = sum(item.silence or 0.0 for item in self.segments[segment + 1 : point.segment])
        return min(last + pauses / 1000, max(last, self.duration))

    def _selected(self, parts: list[str], following: int, reference: str) -> float:
        end = len(parts) > 1 and parts[-1] == "end"
        parts = parts[:-1] if end else parts
        kind, which = parts[0], parts[1] if len(parts) > 1 else "1"
        if kind == "word" and len(parts) <= 2:
            found = self._word(which, following, reference)
        elif kind == "phone" and len(parts) <= 2:
            found = self._phone(which, following, reference)
        else:
            raise InputError(
                f"{reference!r}: after a point comes word, word.2, phone.2 or phone.UW, then .end if wanted"
            )
        return found.end if end else found.start

    def _word(self, which: str, following: int, reference: str) -> Interval:
        number = following + int(which) - 1 if is_whole(which) else -1
        if not following <= number < len(self.words):
            left = len(self.words) - following
            raise InputError(f"{reference!r}: there are {left} words from there on, so no word {which!r}")
        return self.words[number]

    def _phone(self, which: str, following: int, reference: str) -> Interval:
        if following >= len(self.words):
            raise InputError(f"{reference!r}: no word follows, so it has no phone {which!r}")
        start = self.words[following].start
        later = [phone for phone in self.phones if phone.start >= start - 1e-6 and phone.label != PAUSE]
        if is_whole(which):
            inside = [phone for phone in later if phone.start < self.words[following].end - 1e-6]
            if not 1 <= int(which) <= len(inside):
                word = self.words[following].label
                raise InputError(f"{reference!r}: the word {word!r} has {len(inside)} phones, so no phone {which}")
            return inside[int(which) - 1]
        found = next((phone for phone in later if phone.label == which.upper()), None)
        if found is None:
            raise InputError(f"{reference!r}: no phone {which!r} is said from there on")
        return found


def place(script: Script, joined: Joined, library: CommandLibrary | None = None) -> Spoken:
    """Give everything in a script its time in an utterance.

    Raises
    ------
    InputError
        If a place is not in the text, or a time lies outside the sound; with file and line.
    """
    library = library or shipped_library()
    clock = Clock(joined, script.points, script.segments)
    notes: list[Note] = []
    commands = tuple(
        naming_its_line(item.command.where, partial(_command, item, clock, library, notes)) for item in script.commands
    )
    curves = tuple(naming_its_line(item.where, partial(_curve, item, clock)) for item in script.curves)
    utterance = joined.utterance.with_notes(*script.notes, *notes)
    return Spoken(utterance, emotions_at(script.emotions, clock), commands, curves, _efforts(script.efforts, clock))


def naming_its_line(where: str, job: Callable[[], Result]) -> Result:
    """Do something that may fail; the message then begins with file and line."""
    try:
        return job()
    except InputError as problem:
        if not where or str(problem).startswith(where):
            raise
        raise InputError(f"{where}: {problem}") from problem


def _command(item: DirectedCommand, clock: Clock, library: CommandLibrary, notes: list[Note]) -> Command:
    at = item.at.resolve(clock.time_of)
    _inside(item.command.name, at, clock)
    command = item.command
    if item.until is not None:
        command = _lasting(item, item.until.resolve(clock.time_of) - at, library, notes)
    return command.with_(at=plain(at))


def _inside(name: str, at: float, clock: Clock) -> None:
    if not -_EARLY <= at <= clock.duration * 1000:
        raise InputError(
            f"{name}: its time, {at / 1000:g} s, lies outside the sound, which lasts {clock.duration:.3f} s "
            "(plain numbers are milliseconds from its start)"
        )


def _lasting(item: DirectedCommand, length: float, library: CommandLibrary, notes: list[Note]) -> Command:
    """A command whose length is that of what it stands around."""
    command = item.command
    if length <= 0:
        raise InputError(f"{command.name}: it would end {-length:g} ms before it begins")
    has, given = library[command.name].parameters, command.given
    if "count" in has and "count" in given and "period" in has and not {"period", "frequency"} & set(given):
        return command.with_(period=plain(round(length / float(given["count"]), 3)))
    if {"count", "end", "duration"} & set(given):
        return command
    for name in ("end", "duration"):
        if name in has:
            return command.with_(**{name: plain(round(length, 3))})
    notes.append(Note("note", f"{command.where}: {command.name} has a length of its own"))
    return command


def _curve(item: DirectedCurve, clock: Clock) -> ParameterCurve:
    keys = tuple((moment.resolve(clock.time_of), value) for moment, value in item.keys)
    if keys[-1][0] < 0 or keys[0][0] > clock.duration * 1000:
        _inside(f"curve of {item.parameter}", keys[0][0] if keys[0][0] > 0 else keys[-1][0] - 2 * _EARLY, clock)
    return ParameterCurve(item.parameter, keys, item.interpolation, "set" if item.mode == "set" else "add", item.fade)


def emotions_at(emotions: Sequence[DirectedEmotion], clock: Clock) -> tuple[EmotionSpan, ...]:
    """The emotions of a script in seconds."""

    def seconds(moment: Moment | None) -> float | None:
        return None if moment is None else moment.resolve(clock.time_of) / 1000

    def strength(emotion: DirectedEmotion) -> float | IntensityCurve:
        if not emotion.keys:
            return emotion.intensity
        return IntensityCurve(*_rising(emotion.keys, clock, f"emotion {emotion.name!r}: the points of its intensity"))

    spans = [EmotionSpan(e.name, strength(e), start=seconds(e.start), end=seconds(e.end)) for e in emotions]
    return tuple(s for s in spans if s.start is None or s.end is None or s.end > s.start)


def _efforts(efforts: Sequence[DirectedEffort], clock: Clock) -> tuple[EffortSpan, ...]:
    spans = []
    for effort in efforts:
        start, end = (moment.resolve(clock.time_of) / 1000 for moment in (effort.start, effort.end))
        if end > start:
            keys = effort.keys
            level = EffortCurve(*_rising(keys, clock, "effort: the points of its level")) if keys else effort.level
            spans.append(EffortSpan(level, start, end))
    return tuple(spans)


def _rising(
    keys: Sequence[tuple[Moment, float]], clock: Clock, what: str
) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Seconds and values of the points of a curve."""
    placed = [(moment.resolve(clock.time_of) / 1000, value) for moment, value in keys]
    if any(after[0] <= before[0] for before, after in pairwise(placed)):
        told = ", ".join(f"{value:g} at {at:.3f} s" for at, value in placed)
        raise InputError(f"{what} do not rise in time: {told}")
    return tuple(at for at, _ in placed), tuple(value for _, value in placed)
