"""`TakeRequest`: what the page may ask for, checked before any work is done.

Whatever could name a file is refused here: an emotion in a CSV, a performer or a phone map in a file. The studio reads
only what it ships with and what was uploaded to it.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from typing import Any

from mien.animation.edits import EditLayer, layer_of
from mien.core.errors import InputError, unknown_name
from mien.core.timeline import FrameRate
from mien.serve.studio.field_error import FieldError
from mien.serve.studio.given_speech import GivenTimes
from mien.serve.studio.settings import Limits
from mien.text.effort_spans import parse_effort
from mien.text.score import EmotionSpan

__all__ = ["FieldError", "TakeRequest", "checked_layer"]

_FILE_NAME = re.compile(r"\.csv\s*$", re.IGNORECASE)
_RATE = re.compile(r"\d{1,6}(\.\d{1,9})?|\d{1,6}/\d{1,5}")
_MOST_EMOTIONS = 16
_MOST_SEED = 2**32 - 1


@dataclass(frozen=True)
class TakeRequest:
    """A line to be performed.

    Attributes
    ----------
    text : str
        What is said, tags allowed (``docs/script.md``); may be empty with a sound, whose words then are recognised.
    emotion : tuple of str
        As for `mien.say`, without files; ``"auto"`` with a sound.
    voice, language, speech_model : str or None
    fps : str
    seed : int
    performer : str
    prosody, voice_emotion : float
    effort : str
        As for `mien.say` and `mien.animate`, without files; ``""``: as the emotions have it, else of a sound;
        ``"auto"`` with a sound, whatever is felt.
    song : bool
        The sound is a song and the text its lyrics.
    times : GivenTimes or None
        Words and phones as a person corrected them; None: as they were found.
    """

    text: str = ""
    emotion: tuple[str, ...] = ()
    voice: str | None = None
    language: str | None = None
    fps: str = "60"
    seed: int = 0
    performer: str = "default"
    speech_model: str | None = None
    prosody: float = 0.5
    effort: str = ""
    voice_emotion: float = 1.0
    song: bool = False
    times: GivenTimes | None = None

    @classmethod
    def of(cls, asked: Mapping[str, Any], limits: Limits, with_sound: bool = False) -> TakeRequest:
        """Read a request.

        Raises
        ------
        FieldError
            Naming the field that cannot be used.
        """
        return cls().changed(asked, limits, with_sound)

    def changed(self, asked: Mapping[str, Any], limits: Limits, with_sound: bool = False) -> TakeRequest:
        """The same request with some fields changed; null gives a field its default back.

        Raises
        ------
        FieldError
            Naming the field that cannot be used.
        """
        known = {field.name: field.default for field in fields(TakeRequest)}
        read: dict[str, Any] = {}
        for name, value in asked.items():
            if name not in known:
                raise FieldError(str(name)[:40], str(unknown_name("field", str(name)[:40], known)))
            read[name] = known[name] if value is None else _READERS[name](value, limits)
        if self.effort == "auto" and not with_sound:  # the sound that it was read from is gone
            read = {"effort": ""} | read
        request = replace(self, **read)
        request._check(with_sound)
        return request

    def _check(self, with_sound: bool) -> None:
        if not with_sound and not self.text.strip():
            raise FieldError("text", "expected a text to say, got an empty one")
        if not with_sound and "auto" in self.emotion:
            raise FieldError("emotion", "'auto' reads the emotion from a recorded voice: upload a sound, or name one")
        if not with_sound and self.effort == "auto":
            raise FieldError("effort", "'auto' reads the effort from a recorded voice: upload a sound, or leave it out")
        if not with_sound and self.song:
            raise FieldError("song", "a song is sung by the sound: upload one")
        if self.song and not self.text.strip():
            raise FieldError("text", "a song needs its lyrics as text")

    def plain(self) -> dict[str, Any]:
        """As JSON, all fields."""
        plain = {field.name: getattr(self, field.name) for field in fields(self)} | {"emotion": list(self.emotion)}
        return plain | {"times": None if self.times is None else self.times.plain()}


def checked_layer(document: dict[str, Any], limits: Limits) -> EditLayer:
    """Read a layer from JSON; a bare ``{"edits": [...]}`` counts as one of this version.

    Raises
    ------
    FieldError
        If it does not hold together, or is larger than the studio takes.
    """
    document = (
        {"format": "mien-edits", "version": 1, **document.get("layer", document)}
        if isinstance(document.get("layer", document), dict)
        else document
    )
    try:
        layer = layer_of(document)
    except InputError as problem:
        raise FieldError("edits", str(problem)) from problem
    points = sum(len(edit.points) for _, edit in layer.intensities) + sum(len(edit.keys) for _, edit in layer.curves)
    if len(layer.edits) + points > limits.edits or len(layer.line or ()) > limits.text_characters:
        raise FieldError("edits", f"the studio takes at most {limits.edits} edits and points, got more")
    return layer


def _text(value: Any, limits: Limits) -> str:
    if not isinstance(value, str):
        raise FieldError("text", "expected a text")
    if len(value) > limits.text_characters:
        raise FieldError("text", f"a line has at most {limits.text_characters} characters here, got {len(value)}")
    if any(0xD800 <= ord(sign) < 0xE000 for sign in value):
        raise FieldError("text", "the text holds half a sign (a lone surrogate)")
    return value


def _emotions(value: Any, limits: Limits) -> tuple[str, ...]:
    asked = [value] if isinstance(value, str) else value
    if not isinstance(asked, (list, tuple)) or not all(isinstance(one, str) and len(one) < 2000 for one in asked):
        raise FieldError("emotion", "expected an emotion such as happy:0.6, or a list of them")
    if len(asked) > _MOST_EMOTIONS:
        raise FieldError("emotion", f"expected at most {_MOST_EMOTIONS} emotions, got {len(asked)}")
    read = []
    for one in asked:
        if not one.strip():
            continue
        if _FILE_NAME.search(one):
            raise FieldError("emotion", "the studio reads no files by name: draw the intensity on the timeline")
        if one.strip().lower() != "auto":
            try:
                EmotionSpan.parse(one)
            except InputError as problem:
                raise FieldError("emotion", str(problem)) from problem
        read.append(one.strip().lower() if one.strip().lower() == "auto" else one.strip())
    return tuple(read)


def _voice(value: Any, limits: Limits) -> str:
    from mien.speech.voices import catalogue

    names = [voice.name for voice in catalogue()]
    if value not in names:
        raise FieldError("voice", str(unknown_name("voice", str(value)[:60], names)))
    return str(value)


def _language(value: Any, limits: Limits) -> str:
    from mien.text.languages import find_language, known_languages

    tag = str(value)[:20]
    if not re.fullmatch(r"[A-Za-z]{2,3}(-[A-Za-z0-9]{1,8})*", tag):
        raise FieldError("language", str(unknown_name("language", tag, ("en", *known_languages()))))
    try:
        find_language(tag)
    except InputError as problem:
        raise FieldError("language", str(problem)) from problem
    return tag


def _fps(value: Any, limits: Limits) -> str:
    try:
        if isinstance(value, bool) or not _RATE.fullmatch(str(value).strip()):
            raise InputError("a frame rate is a number above 0 such as 30 or 29.97")
        rate = FrameRate.of(value)
    except (InputError, ValueError) as problem:
        raise FieldError("fps", str(problem)) from problem
    if not 1 <= rate.fps <= limits.fps:
        raise FieldError("fps", f"the studio shows 1 to {limits.fps:g} frames per second, not {rate.fps:g}")
    return str(value).strip()


def _seed(value: Any, limits: Limits) -> int:
    if isinstance(value, str) and re.fullmatch(r"\d{1,10}", value):
        value = int(value)
    if isinstance(value, bool) or not isinstance(value, int) or not 0 <= value <= _MOST_SEED:
        raise FieldError("seed", f"a seed is a whole number from 0 to {_MOST_SEED}")
    return value


def _performer(value: Any, limits: Limits) -> str:
    from mien.motion.performers import FORMER_NAME, HAND_MADE, known_performers

    if value == FORMER_NAME:
        value = HAND_MADE
    if value not in known_performers():
        raise FieldError("performer", str(unknown_name("performer", str(value)[:60], known_performers())))
    return str(value)


def _speech_model(value: Any, limits: Limits) -> str:
    models = ("coarticulation", "graph", "both")
    if value not in models:
        raise FieldError("speech_model", str(unknown_name("speech model", str(value)[:60], models)))
    return str(value)


def _prosody(value: Any, limits: Limits) -> float:
    try:
        strength = 0.0 if value == "off" else float(value)
    except (TypeError, ValueError, OverflowError):
        strength = -1.0
    if not 0 <= strength <= 1:
        raise FieldError("prosody", "visual prosody is 'off' or a number from 0 to 1")
    return strength


def _effort(value: Any, limits: Limits) -> str:
    text = str(value)[:2000].strip().lower()
    if text.endswith(".csv"):
        raise FieldError("effort", "an effort is 'auto', 'off', a number from 0 to 2 or points such as 0.5@0,1.6@2")
    if text not in ("", "auto", "off"):
        try:
            parse_effort(text)
        except InputError as problem:
            raise FieldError("effort", str(problem)) from problem
    return text


def _voice_emotion(value: Any, limits: Limits) -> float:
    from mien.pipeline.options import share_of

    try:
        return share_of("emotion in the voice", value)
    except InputError as problem:
        raise FieldError("voice_emotion", str(problem)) from problem


def _song(value: Any, limits: Limits) -> bool:
    truths = {True: True, False: False, "true": True, "false": False, "1": True, "0": False}
    if not isinstance(value, (bool, str)) or value not in truths:
        raise FieldError("song", "expected true or false")
    return truths[value]


def _times(value: Any, limits: Limits) -> GivenTimes:
    try:
        return GivenTimes.of(value)
    except InputError as problem:
        raise FieldError("times", str(problem)) from problem


_READERS = {
    "text": _text,
    "emotion": _emotions,
    "voice": _voice,
    "language": _language,
    "fps": _fps,
    "seed": _seed,
    "performer": _performer,
    "speech_model": _speech_model,
    "prosody": _prosody,
    "effort": _effort,
    "voice_emotion": _voice_emotion,
    "song": _song,
    "times": _times,
}
