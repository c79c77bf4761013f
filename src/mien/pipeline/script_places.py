"""When the points of a script are reached, once its words and phones have times."""

from __future__ import annotations

from collections.abc import Sequence

from mien.core.errors import InputError
from mien.core.limits import is_whole
from mien.core.timeline import Interval
from mien.core.utterance import PAUSE
from mien.pipeline.spoken_joining import Joined
from mien.text.script import Point, Segment

__all__ = ["Clock"]


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
