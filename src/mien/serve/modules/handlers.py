"""What each of the four modules makes of a message."""

from __future__ import annotations

import json
from collections.abc import Callable, Collection, Iterable, Iterator
from pathlib import Path
from xml.etree.ElementTree import Element

from mien.animation.animation import Animation
from mien.animation.edits import EMPTY, EditLayer
from mien.core.errors import InputError, Note, unknown_name
from mien.core.timeline import FrameRate
from mien.motion.performer import Performer
from mien.pipeline.edited_performance import perform_spoken
from mien.pipeline.speak import speak
from mien.pipeline.spoken import Spoken, translate
from mien.serve.modules.messages import Message
from mien.serve.modules.xml_form import (
    curve_element,
    curves_element,
    element_of,
    one_line,
    read_command,
    read_curve,
    read_script_element,
    read_spoken,
    script_element,
    spoken_element,
)
from mien.text.commands import CommandLibrary
from mien.text.parameter_curves import ParameterCurve
from mien.text.score import UNDIRECTED, Score
from mien.text.script import DirectedCurve, Script
from mien.text.script_reading import read_script
from mien.text.sync_points import Moment

__all__ = ["Interpret", "Perform", "Speak", "Translate", "frame_lines", "output_path", "refusal_frame", "silence_for"]

Tell = Callable[[Iterable[Note]], None]


def _bare(message: Message, library: CommandLibrary) -> Element | None:
    """The element of a message that is a bare command, high or low; else None."""
    if not message.text.lstrip().startswith("<"):
        return None
    try:
        element = element_of(message.text)
    except InputError:
        return None
    low = element.tag == "curves" or (element.find("key") is not None and element.tag not in ("script", "curve"))
    lone = element.tag in library and not len(element) and not (element.text or "").strip()
    timed = lone and element.get("at", "").replace(".", "", 1).isdigit()
    return element if low or timed else None


def _unexpected(element: Element, expected: str, library: CommandLibrary) -> InputError:
    if element.tag in library or element.tag in ("interpreted", "spoken", "directed"):
        return InputError(f"expected {expected}, got <{element.tag}>")
    return unknown_name(f"message (expected {expected})", element.tag, library.names)


class Interpret:
    """Text with tags, or a document, to ``interpreted``; bare commands pass once they are known to be right."""

    def __init__(self, library: CommandLibrary, source: str = "text") -> None:
        self.library, self.source = library, source

    def __call__(self, message: Message, number: int) -> Iterator[str]:
        """Lines for one message."""
        bare = _bare(message, self.library)
        if bare is not None:
            yield from _checked(bare, self.library)
            return
        script = read_script(message.text, self.library, self.source)
        yield one_line(script_element(script, str(number)))


def _checked(element: Element, library: CommandLibrary) -> Iterator[str]:
    if element.tag == "curves":
        yield one_line(curves_element(tuple(read_curve(item) for item in element)))
    elif element.find("key") is not None:
        yield one_line(curve_element(read_curve(element)))
    else:
        read_command(element, library)
        yield one_line(element)


class Speak:
    """``interpreted`` to ``spoken``: speech, and a time for everything; bare commands pass."""

    def __init__(
        self,
        library: CommandLibrary,
        voice: str | None = None,
        seed: int = 0,
        language: str | None = None,
        voice_emotion: float = 1.0,
        score: Score = UNDIRECTED,
    ) -> None:
        self.library, self.voice, self.seed, self.language = library, voice, seed, language
        self.voice_emotion, self.score = voice_emotion, score

    def __call__(self, message: Message, number: int) -> Iterator[str]:
        """Lines for one message."""
        bare = _bare(message, self.library)
        if bare is not None:
            yield from _checked(bare, self.library)
            return
        element = element_of(message.text)
        if element.tag != "interpreted":
            raise _unexpected(element, "<interpreted> from 'mien interpret', or a command", self.library)
        script = read_script_element(element)
        spoken = speak(script, self.voice, self.seed, self.library, self.language, self.score, self.voice_emotion)
        yield one_line(spoken_element(spoken, element.get("id", str(number))))


class Translate:
    """``spoken`` to ``directed``, and bare commands to low-level ones: one line for each face parameter."""

    def __init__(self, library: CommandLibrary, tell: Tell) -> None:
        self.library, self.tell = library, tell

    def __call__(self, message: Message, number: int) -> Iterator[str]:
        """Lines for one message."""
        element = element_of(message.text)
        if element.tag in ("spoken", "directed"):
            spoken = translate(read_spoken(element), self.library)
            yield one_line(spoken_element(spoken, element.get("id", str(number))))
        elif element.tag == "curves" or element.find("key") is not None:
            yield from _checked(element, self.library)
        elif element.tag == "interpreted":
            raise _unexpected(element, "<spoken> from 'mien speak', or a command", self.library)
        else:
            translation = self.library.translate(read_command(element, self.library))
            self.tell(translation.notes)
            yield one_line(curves_element(translation.curves))


class Perform:
    """``directed`` to frames (all lines of an utterance are one message), or to a file; bare commands over silence."""

    def __init__(
        self,
        library: CommandLibrary,
        performer: Performer,
        rate: FrameRate,
        seed: int,
        score: Score,
        save: Callable[[Animation, str, str], None] | None,
        edits: EditLayer = EMPTY,
    ) -> None:
        self.library, self.performer, self.rate, self.seed = library, performer, rate, seed
        self.score, self.save, self.edits = score, save, edits

    def __call__(self, message: Message, number: int) -> Iterator[str]:
        """Lines for one message."""
        element = element_of(message.text)
        name = element.get("id", str(number))
        if element.tag in ("spoken", "directed"):
            spoken = translate(read_spoken(element), self.library)
        elif element.find("key") is not None:
            spoken = silence_for((read_curve(element),))
        elif element.tag == "curves":
            spoken = silence_for(tuple(read_curve(item) for item in element))
        elif element.tag == "interpreted":
            raise _unexpected(element, "<directed> from 'mien translate', or a command", self.library)
        else:
            spoken = silence_for(self.library.translate(read_command(element, self.library)).curves)
        self.performer.expression.check(Score(self.score.emotions + spoken.emotions))
        animation = perform_spoken(spoken, self.performer, self.rate, self.seed, self.score, self.edits)
        if self.save is not None:
            self.save(animation, name, message.sender)
        else:
            yield "\n".join(frame_lines(animation, name))


def silence_for(curves: tuple[ParameterCurve, ...]) -> Spoken:
    """Curves over a silence that lasts as long as they take."""
    keys = [tuple((Moment(offset=at), value) for at, value in curve.keys) for curve in curves]
    timed = tuple(DirectedCurve(curve.parameter, key) for curve, key in zip(curves, keys, strict=True))
    return Spoken(speak(Script(curves=timed)).utterance, curves=curves)


def frame_lines(animation: Animation, name: str) -> Iterator[str]:
    """An animation as JSON lines: what it is, each frame, and that it is over."""
    track = animation.channels
    about = {
        "utterance": name,
        "fps": str(animation.rate.fraction),
        "frames": len(track),
        "seconds": animation.utterance.duration,
        "text": animation.utterance.text,
        "channels": list(track.names),
    }
    yield json.dumps(about, ensure_ascii=False)
    for number, row in enumerate(track.values):
        frame = {"frame": number, "time": animation.rate.time_of(number), "values": row.tolist()}
        yield json.dumps(frame, separators=(",", ":"))
    yield json.dumps({"end": name, "frames": len(track)})


def refusal_frame(module: str, line: int, reason: str) -> str:
    """The JSON line that stands among frames in the place of an utterance that was refused."""
    return json.dumps({"refused": " ".join(reason.split()), "module": module, "line": line}, ensure_ascii=False)


def output_path(pattern: str, name: str, sender: str, written: Collection[Path]) -> Path:
    """The file for an utterance: in the pattern, ``{id}`` stands for its id and ``{sender}`` for its sender's.

    Raises
    ------
    InputError
        If it would overwrite one of those that were written for other utterances.

    Examples
    --------
    >>> output_path("line-{id}.mp4", "3", "ab12cd34", ()).name
    'line-3.mp4'
    """
    if "{id}" in pattern and not all(char.isalnum() or char in "._-" for char in name):
        raise InputError(f"the id {name!r} cannot be part of a file name")
    path = Path(pattern.replace("{id}", name).replace("{sender}", sender))
    if path not in written:
        return path
    if "{id}" not in pattern:
        raise InputError(f"a second utterance would overwrite {path}: put {{id}} in the name, as in line-{{id}}.mp4")
    raise InputError(
        f"another utterance with the id {name!r} would overwrite {path}: put {{sender}} in the name as well, "
        "as in line-{sender}-{id}.mp4"
    )
