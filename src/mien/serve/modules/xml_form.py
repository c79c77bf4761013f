"""What goes between the modules, as XML (``docs/modules.md``, ``assets/schemas/stream.rng``), and back, equal.

A message is one element on one line. Times of words and phones are seconds, times of commands and keys milliseconds, as
everywhere in mien. Numbers are the shortest decimals that read back exactly.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any, TypeVar, cast
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

from mien.core.errors import InputError, Note
from mien.core.timeline import Interval, Tier
from mien.core.utterance import Utterance
from mien.formats.sound_text import ENCODING, decode_audio, encode_audio
from mien.pipeline.spoken import Spoken
from mien.text.commands import Command, CommandLibrary
from mien.text.effort_spans import EffortCurve, EffortSpan
from mien.text.intensity import Curve, IntensityCurve
from mien.text.parameter_curves import ParameterCurve
from mien.text.score import EmotionSpan
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
from mien.text.sync_points import Moment, plain

__all__ = [
    "curve_element",
    "curves_element",
    "element_of",
    "one_line",
    "read_command",
    "read_curve",
    "read_script_element",
    "read_spoken",
    "script_element",
    "spoken_element",
]

Item = TypeVar("Item")
STRENGTHS = {"emotion": "intensity", "effort": "level"}
"""Attribute that tells how strong an emotion or an effort is, where that does not change."""
WHERE = "where"
"""Attribute of a command in a `spoken` message that tells its file and line."""


def one_line(element: Element) -> str:
    """An element as text without line ends."""
    text = ElementTree.tostring(element, encoding="unicode")
    return text.replace(" />", "/>").replace("\r", "&#13;").replace("\n", "&#10;")


def element_of(text: str) -> Element:
    """The element that a text is.

    Raises
    ------
    InputError
        If it is not well-formed XML.
    """
    try:
        return ElementTree.fromstring(text)
    except ElementTree.ParseError as problem:
        line, column = problem.position
        reason = str(problem).partition(":")[0]
        raise InputError(f"not well-formed XML: {reason} in line {line}, column {column + 1}") from problem


# ---- Script --------------------------------------------------------------------------------------------------------


def _given(**attributes: str | float | int | None) -> dict[str, str]:
    """Attributes that are not None."""
    kept = {name.rstrip("_"): value for name, value in attributes.items() if value is not None}
    return {name: value if isinstance(value, str) else plain(float(value)) for name, value in kept.items()}


def script_element(script: Script, number: str) -> Element:
    """A script as the message ``interpreted``."""
    root = Element("interpreted", _given(id=number, voice=script.voice, language=script.language))
    for segment in script.segments:
        start = None if segment.start is None else str(segment.start)
        item = SubElement(root, "segment", _given(silence=segment.silence, start=start, voice=segment.voice))
        item.text = segment.text
        for spelling in segment.spellings:
            phones = " ".join(spelling.phones)
            SubElement(item, "spelling", _given(start=spelling.start, end=spelling.end, phones=phones))
    for point in script.points:
        place = _given(name=point.name, segment=point.segment, place=point.place)
        SubElement(root, "point", place | ({"after": "true"} if point.after else {}))
    for stretch in script.prosody:
        given = _given(from_=str(stretch.start), to=str(stretch.end))
        SubElement(root, "prosody", given | _given(rate=stretch.rate, pitch=stretch.pitch, volume=stretch.volume))
    for emotion in script.emotions:
        start, end = (None if moment is None else str(moment) for moment in (emotion.start, emotion.end))
        item = SubElement(root, "emotion", _given(name=emotion.name, intensity=emotion.intensity, from_=start, to=end))
        for moment, value in emotion.keys:
            SubElement(item, "key", _given(at=str(moment), value=value))
    for effort in script.efforts:
        placed = _given(level=effort.level, from_=str(effort.start), to=str(effort.end))
        item = SubElement(root, "effort", placed)
        for moment, value in effort.keys:
            SubElement(item, "key", _given(at=str(moment), value=value))
    for directed in script.commands:
        until = None if directed.until is None else str(directed.until)
        item = SubElement(root, "do", _given(at=str(directed.at), until=until, where=directed.command.where or None))
        SubElement(item, directed.command.name, directed.command.given)
    for curve in script.curves:
        item = SubElement(root, "curve", _given(parameter=curve.parameter) | _shape(curve))
        item.attrib |= _given(where=curve.where or None)
        for moment, value in curve.keys:
            SubElement(item, "key", _given(at=str(moment), value=value))
    _add_notes(root, script.notes)
    return root


def _shape(curve: DirectedCurve | ParameterCurve) -> dict[str, str]:
    """What of a curve differs from the usual."""
    shape = {"interp": curve.interpolation} if curve.interpolation != "linear" else {}
    shape |= {"mode": curve.mode} if curve.mode != "add" else {}
    if isinstance(curve, ParameterCurve) and curve.tangents:
        shape["tangents"] = " ".join(curve.tangents)
    return shape | ({"fade": plain(curve.fade)} if curve.fade else {})


def _add_notes(root: Element, notes: Iterable[Note]) -> None:
    for note in notes:
        SubElement(root, "note", {"kind": note.kind}).text = note.message


def _read_notes(root: Element) -> tuple[Note, ...]:
    return tuple(Note(cast(Any, item.get("kind", "note")), item.text or "") for item in root.findall("note"))


class _Fields:
    """An element's attributes, with faults that name it."""

    def __init__(self, element: Element) -> None:
        self.element = element

    def text(self, name: str) -> str:
        if name not in self.element.attrib:
            raise InputError(f"<{self.element.tag}> lacks {name}=")
        return self.element.attrib[name]

    def number(self, name: str, default: float | None = None) -> float:
        if name not in self.element.attrib and default is not None:
            return default
        try:
            return float(self.text(name))
        except ValueError:
            raise InputError(f"<{self.element.tag}>: {name} is a number, not {self.text(name)!r}") from None

    def whole(self, name: str) -> int:
        number = self.number(name)
        if number != int(number):
            raise InputError(f"<{self.element.tag}>: {name} is a whole number, not {self.text(name)!r}")
        return int(number)

    def moment(self, name: str) -> Moment | None:
        found = self.element.get(name)
        return None if found is None else Moment.parse(found)


def _all(root: Element, name: str, read: Callable[[Element], Item]) -> tuple[Item, ...]:
    return tuple(read(item) for item in root.findall(name))


def read_script_element(root: Element) -> Script:
    """The script of a message ``interpreted``.

    Raises
    ------
    InputError
        If it lacks something or holds what does not fit.
    """
    return Script(
        _all(root, "segment", _segment),
        _all(root, "point", _point),
        _all(root, "prosody", _prosody),
        _all(root, "emotion", _directed_emotion),
        _all(root, "do", _directed_command),
        _all(root, "curve", _directed_curve),
        root.get("voice"),
        root.get("language"),
        _read_notes(root),
        _all(root, "effort", _directed_effort),
    )


def _segment(item: Element) -> Segment:
    fields = _Fields(item)
    silence = fields.number("silence") if "silence" in item.attrib else None
    spellings = _all(item, "spelling", _spelling)
    return Segment(item.text or "", silence, fields.moment("start"), item.get("voice"), spellings)


def _spelling(item: Element) -> Spelling:
    fields = _Fields(item)
    return Spelling(fields.whole("start"), fields.whole("end"), tuple(fields.text("phones").split()))


def _point(item: Element) -> Point:
    fields = _Fields(item)
    return Point(fields.text("name"), fields.whole("segment"), fields.whole("place"), item.get("after") == "true")


def _prosody(item: Element) -> Prosody:
    fields = _Fields(item)
    start, end = Moment.parse(fields.text("from")), Moment.parse(fields.text("to"))
    asked = {name: fields.number(name) for name in ("rate", "pitch", "volume") if name in item.attrib}
    return Prosody(start, end, **asked)


def _directed_emotion(item: Element) -> DirectedEmotion:
    fields = _Fields(item)
    name, intensity = fields.text("name"), fields.number("intensity", 1.0)
    return DirectedEmotion(name, intensity, fields.moment("from"), fields.moment("to"), _moments(item))


def _directed_effort(item: Element) -> DirectedEffort:
    fields = _Fields(item)
    start, end = Moment.parse(fields.text("from")), Moment.parse(fields.text("to"))
    return DirectedEffort(fields.number("level"), start, end, _moments(item))


def _moments(item: Element) -> tuple[tuple[Moment, float], ...]:
    """Keys whose times are moments."""
    return tuple((Moment.parse(_Fields(k).text("at")), _Fields(k).number("value")) for k in item.findall("key"))


def _directed_command(item: Element) -> DirectedCommand:
    fields = _Fields(item)
    if len(item) != 1:
        raise InputError(f"<do> holds one command, not {len(item)}")
    command = Command(item[0].tag, tuple(item[0].attrib.items()), item.get("where", ""))
    return DirectedCommand(command, Moment.parse(fields.text("at")), fields.moment("until"))


def _directed_curve(item: Element) -> DirectedCurve:
    fields = _Fields(item)
    keys = _moments(item)
    interpolation, mode = item.get("interp", "linear"), item.get("mode", "add")
    parameter, fade = fields.text("parameter"), fields.number("fade", 0.0)
    return DirectedCurve(parameter, keys, interpolation, mode, fade, item.get("where", ""))


# ---- Spoken --------------------------------------------------------------------------------------------------------


def spoken_element(spoken: Spoken, number: str) -> Element:
    """What was spoken as the message ``spoken``, or ``directed`` if no command is left to be translated."""
    speech = spoken.utterance
    name = "spoken" if spoken.commands else "directed"
    root = Element(name, {"id": number, "language": speech.language, "timing": speech.timing})
    SubElement(root, "text").text = speech.text
    sound = _given(rate=speech.audio.rate, samples=len(speech.audio), encoding=ENCODING)
    SubElement(root, "sound", sound).text = encode_audio(speech.audio)
    tiers = [("words", speech.words), ("phones", speech.phones)]
    if speech.native is not None:
        tiers.append(("natives", speech.native))
    if speech.sung:
        root.set("sung", "true")
    for kind, tier in tiers:
        group = SubElement(root, kind)
        for item in tier:
            SubElement(group, kind[:-1], _given(start=item.start, end=item.end)).text = item.label
    for shape in speech.shapes:
        SubElement(root, "shape").text = " ".join(shape)
    for emotion in spoken.emotions:
        root.append(_span_element("emotion", emotion, emotion.intensity, name=emotion.name))
    for effort in spoken.efforts:
        source = None if effort.source == "asked" else effort.source
        root.append(_span_element("effort", effort, effort.level, source=source))
    group = SubElement(root, "commands")
    for command in spoken.commands:
        SubElement(group, command.name, command.given | ({WHERE: command.where} if command.where else {}))
    group = SubElement(root, "curves")
    group.extend(curve_element(curve) for curve in spoken.curves)
    _add_notes(root, speech.notes)
    return root


def _span_element(
    tag: str, span: EmotionSpan | EffortSpan, strength: float | IntensityCurve, **given: str | None
) -> Element:
    """An emotion or an effort in seconds; a strength that changes as keys."""
    attributes = _given(**given, start=span.start, end=span.end)
    if not isinstance(strength, IntensityCurve):
        return Element(tag, attributes | _given(**{STRENGTHS[tag]: strength}))
    shape = {} if strength.interpolation == "smooth" else {"interp": strength.interpolation}
    root = Element(tag, attributes | shape)
    for at, value in zip(strength.times, strength.values, strict=True):
        SubElement(root, "key", _given(at=at, value=value))
    return root


def curve_element(curve: ParameterCurve) -> Element:
    """A low-level command: an element named like the face parameter, with its keys.

    Examples
    --------
    >>> one_line(curve_element(ParameterCurve("HeadNod", ((1000.0, 0.0), (1166.5, 0.09)))))
    '<HeadNod><key at="1000" value="0"/><key at="1166.5" value="0.09"/></HeadNod>'
    """
    root = Element(curve.parameter, _shape(curve))
    for at, value in curve.keys:
        SubElement(root, "key", _given(at=at, value=value))
    return root


def curves_element(curves: tuple[ParameterCurve, ...]) -> Element:
    """The low-level commands of one command: alone, or, where there are several, in an element ``curves``."""
    if len(curves) == 1:
        return curve_element(curves[0])
    root = Element("curves")
    root.extend(curve_element(curve) for curve in curves)
    return root


def read_curve(item: Element) -> ParameterCurve:
    """The curve of a low-level command.

    Raises
    ------
    InputError
        If the parameter is not known or the keys do not fit.
    """
    fields = _Fields(item)
    keys = tuple((_Fields(key).number("at"), _Fields(key).number("value")) for key in item.findall("key"))
    known = ("interp", "mode", "fade", "tangents")
    strange = [name for name in item.attrib if name not in known]
    if strange:
        raise InputError(f"<{item.tag}> with <key> takes {', '.join(known)}, not {strange[0]}")
    mode = cast(Any, item.get("mode", "add"))
    tangents = tuple(item.get("tangents", "").split())
    return ParameterCurve(item.tag, keys, item.get("interp", "linear"), mode, fields.number("fade", 0.0), tangents)


def read_command(item: Element, library: CommandLibrary) -> Command:
    """A bare high-level command.

    Raises
    ------
    InputError
        If it is not known, holds something, or its parameters do not fit.
    """
    if len(item) or (item.text or "").strip():
        raise InputError(f"<{item.tag}> is a command and holds nothing here but <key at= value=/>")
    given = {name: value for name, value in item.attrib.items() if name != WHERE}
    command = Command(item.tag, tuple(given.items()), item.get(WHERE, ""))
    library.check(command)
    return command


def read_spoken(root: Element) -> Spoken:
    """The content of a message ``spoken`` or ``directed``.

    Raises
    ------
    InputError
        If it lacks something or does not hold together.
    """
    sound = root.find("sound")
    if sound is None:
        raise InputError(f"<{root.tag}> lacks <sound>")
    fields = _Fields(sound)
    audio = decode_audio(sound.text or "", fields.whole("rate"), fields.whole("samples"))
    timing = cast(Any, _Fields(root).text("timing"))
    utterance = Utterance(
        root.findtext("text", ""),
        audio,
        _tier(root, "words"),
        _tier(root, "phones"),
        _Fields(root).text("language"),
        timing,
        _read_notes(root),
        _tier(root, "natives", "native") if root.find("natives") is not None else None,
        tuple(tuple((item.text or "").split()) for item in root.findall("shape")),
        root.get("sung") == "true",
    )
    commands = tuple(_spoken_command(item) for item in _group(root, "commands"))
    curves = tuple(read_curve(item) for item in _group(root, "curves"))
    return Spoken(utterance, _all(root, "emotion", _emotion), commands, curves, _all(root, "effort", _effort))


def _group(root: Element, name: str) -> Iterable[Element]:
    group = root.find(name)
    return () if group is None else group


def _spoken_command(item: Element) -> Command:
    given = {name: value for name, value in item.attrib.items() if name != WHERE}
    return Command(item.tag, tuple(given.items()), item.get(WHERE, ""))


def _emotion(item: Element) -> EmotionSpan:
    start, end, intensity = _span(item, IntensityCurve)
    return EmotionSpan(_Fields(item).text("name"), intensity, start=start, end=end)


def _effort(item: Element) -> EffortSpan:
    start, end, level = _span(item, EffortCurve)
    return EffortSpan(level, start, end, cast(Any, item.get("source", "asked")))


def _span(item: Element, kind: type[Curve]) -> tuple[float | None, float | None, float | Curve]:
    """Start, end and strength of an emotion or an effort."""
    fields = _Fields(item)
    start, end = (fields.number(name) if name in item.attrib else None for name in ("start", "end"))
    keys = [(_Fields(key).number("at"), _Fields(key).number("value")) for key in item.findall("key")]
    if not keys:
        return start, end, fields.number(STRENGTHS[item.tag], 1.0)
    between = cast(Any, item.get("interp", "smooth"))
    return start, end, kind(tuple(at for at, _ in keys), tuple(value for _, value in keys), between)


def _tier(root: Element, name: str, tier: str | None = None) -> Tier:
    group = root.find(name)
    if group is None:
        raise InputError(f"<{root.tag}> lacks <{name}>")
    items = ((_Fields(item), item.text or "") for item in group)
    return Tier(tier or name, tuple(Interval(f.number("start"), f.number("end"), label) for f, label in items))
