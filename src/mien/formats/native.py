"""``.json``: the native `Animation`, kept whole.

Everything is there: channels and markers to the last bit, the sound as 24-bit FLAC in base64, words, phones, score,
provenance, notes, and the layer of edits with what it took the place of.
``docs/formats.md`` describes the schema; `FORMAT` and `VERSION` stand in every file.
"""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any, NoReturn, cast

import numpy as np
from numpy.typing import NDArray

from mien.animation.animation import Animation, Provenance
from mien.animation.edits.applied import AppliedEdits, Before, Lost
from mien.animation.edits.layer_file import layer_of, plain_layer
from mien.core.audio import Audio
from mien.core.border import guarded
from mien.core.errors import InputError, Note, OutputError
from mien.core.files import replace_when_complete
from mien.core.limits import fraction_of, read_bytes
from mien.core.plain_text import parsed_json
from mien.core.timeline import MAX_FPS, FrameRate, Interval, Tier
from mien.core.tracks import ChannelTrack, MarkerTrack
from mien.core.utterance import Utterance
from mien.formats.sound_text import ENCODING, decode_audio, encode_audio
from mien.text.effort_spans import EffortCurve, EffortSpan
from mien.text.intensity import Curve, IntensityCurve
from mien.text.parameter_curves import ParameterCurve
from mien.text.score import EmotionSpan, Score

__all__ = ["FORMAT", "VERSION", "read_native", "write_native"]

FORMAT = "mien-animation"
VERSION = 1


def write_native(animation: Animation, path: str | Path) -> tuple[Note, ...]:
    """Write an animation so that `read_native` gives back an equal one.

    Raises
    ------
    OutputError
        If the file cannot be written, or a marker stands at infinity.
    """
    text = json.dumps(_plain(animation), ensure_ascii=False, allow_nan=False, separators=(",", ":"))
    with replace_when_complete(path) as unfinished:
        unfinished.write_text(text + "\n", encoding="utf-8")
    return ()


@guarded("an animation of mien")
def read_native(path: str | Path) -> Animation:
    """Read an animation that `write_native` wrote.

    Raises
    ------
    InputError
        If the file is missing, cut short, of another kind or version, or does not hold together; the message names
        the file and the place in it.

    Examples
    --------
    >>> read_native("nowhere.json")
    Traceback (most recent call last):
    mien.core.errors.InputError: nowhere.json: no such file
    """
    path = Path(path)
    content = read_bytes(path, "document")
    try:
        document = parsed_json(content.decode("utf-8-sig"), parse_constant=_refuse_constant)
    except UnicodeDecodeError as problem:
        raise InputError(f"{path} is not a {FORMAT} file: it is not text in UTF-8") from problem
    except ValueError as problem:
        raise InputError(f"{path} is not a whole {FORMAT} file: {problem}; was it cut short?") from problem
    return _animation(_Node(document, path, ""))


# ---------------------------------------------------------------- writing


def _plain(animation: Animation) -> dict[str, Any]:
    speech = animation.utterance
    return {
        "format": FORMAT,
        "version": VERSION,
        "provenance": vars(animation.provenance) | {"seed": int(animation.provenance.seed)},
        "score": {
            "emotions": [_plain_emotion(span) for span in animation.score.emotions],
            "curves": [vars(curve) for curve in animation.score.curves],
            "efforts": [vars(span) | {"level": _plain_strength(span.level)} for span in animation.score.efforts],
        },
        "notes": [vars(note) for note in animation.notes],
        "utterance": {
            "text": speech.text,
            "language": speech.language,
            "timing": speech.timing,
            "words": _plain_tier(speech.words),
            "phones": _plain_tier(speech.phones),
            "native": None if speech.native is None else _plain_tier(speech.native),
            "shapes": [list(names) for names in speech.shapes],
            "sung": speech.sung,
            "notes": [vars(note) for note in speech.notes],
            "audio": _plain_audio(speech.audio),
        },
        "channels": {
            "names": list(animation.channels.names),
            "rate": str(animation.channels.rate.fraction),
            "frames": len(animation.channels),
            "values": animation.channels.values.tolist(),
        },
        "markers": None if animation.markers is None else _plain_markers(animation.markers),
        "edits": None if animation.edits is None else _plain_edits(animation.edits),
    } | ({"timecode": animation.timecode} if animation.timecode else {})


def _plain_edits(edits: AppliedEdits) -> dict[str, Any]:
    before = edits.before
    return {
        "layer": plain_layer(edits.layer),
        "lost": [vars(loss) for loss in edits.lost],
        "before": {
            "words": _plain_tier(before.words),
            "phones": _plain_tier(before.phones),
            "native": None if before.native is None else _plain_tier(before.native),
            "emotions": [_plain_emotion(span) for span in before.emotions],
            "channels": {name: values.tolist() for name, values in before.channels.items()},
        },
    }


def _plain_tier(tier: Tier) -> dict[str, Any]:
    return {"name": tier.name, "intervals": [[float(i.start), float(i.end), i.label] for i in tier]}


def _plain_emotion(span: EmotionSpan) -> dict[str, Any]:
    return vars(span) | {"intensity": _plain_strength(span.intensity)}


def _plain_strength(strength: float | IntensityCurve) -> dict[str, Any] | float:
    return vars(strength) if isinstance(strength, IntensityCurve) else float(strength)


def _plain_markers(markers: MarkerTrack) -> dict[str, Any]:
    if np.isinf(markers.positions).any():
        frame, marker, _ = np.argwhere(np.isinf(markers.positions))[0]
        raise OutputError(f"cannot write markers: {markers.names[marker]!r} is infinitely far away in frame {frame}")
    positions = markers.positions.astype(object)
    positions[np.isnan(markers.positions)] = None
    return {
        "names": list(markers.names),
        "rate": str(markers.rate.fraction),
        "frames": len(markers),
        "positions": positions.tolist(),
    }


def _plain_audio(audio: Audio) -> dict[str, Any]:
    return {"rate": audio.rate, "samples": len(audio), "encoding": ENCODING, "data": encode_audio(audio)}


# ---------------------------------------------------------------- reading


def _refuse_constant(name: str) -> NoReturn:
    raise ValueError(f"{name} is not JSON")


class _Node:
    """A value of the document that knows where it stands, so that every fault can name its place."""

    def __init__(self, value: Any, path: Path, place: str) -> None:
        self.value, self.path, self.place = value, path, place

    def fault(self, message: str) -> InputError:
        return InputError(f"{self.path}: {self.place or 'the whole file'}: {message}")

    def get(self, name: str) -> _Node:
        if not isinstance(self.value, dict):
            raise self.fault(f"expected an object, got {_kind(self.value)}")
        if name not in self.value:
            raise self.fault(f"the field {name!r} is missing; was the file edited by hand?")
        return _Node(self.value[name], self.path, f"{self.place}.{name}" if self.place else name)

    def holds(self, name: str) -> bool:
        """Whether a field that older files lack is there, and not null."""
        return isinstance(self.value, dict) and self.value.get(name) is not None

    def truth(self) -> bool:
        if not isinstance(self.value, bool):
            raise self.fault(f"expected true or false, got {_kind(self.value)}")
        return self.value

    def items(self) -> list[_Node]:
        if not isinstance(self.value, list):
            raise self.fault(f"expected a list, got {_kind(self.value)}")
        return [_Node(item, self.path, f"{self.place}[{number}]") for number, item in enumerate(self.value)]

    def text(self) -> str:
        if not isinstance(self.value, str):
            raise self.fault(f"expected text, got {_kind(self.value)}")
        return self.value

    def number(self) -> float:
        if isinstance(self.value, bool) or not isinstance(self.value, int | float) or not math.isfinite(self.value):
            raise self.fault(f"expected a finite number, got {_kind(self.value)}")
        return self.value

    def whole(self) -> int:
        if isinstance(self.value, bool) or not isinstance(self.value, int):
            raise self.fault(f"expected a whole number, got {_kind(self.value)}")
        return self.value

    def one_of(self, *known: str) -> str:
        if self.text() not in known:
            raise self.fault(f"expected one of {', '.join(known)}, got {self.value!r}")
        return self.text()

    def array(self, shape: tuple[int, ...]) -> NDArray[np.float64]:
        if not isinstance(self.value, list):
            raise self.fault(f"expected a list, got {_kind(self.value)}")
        try:
            array = np.array(self.value, dtype=np.float64)  # null becomes NaN
        except (ValueError, TypeError, OverflowError) as problem:
            raise self.fault(f"expected numbers in the shape {shape}: rows differ or hold other things") from problem
        if array.size == 0 and math.prod(shape) == 0 and len(self.value) == shape[0]:
            return array.reshape(shape)
        if array.shape != shape:
            raise self.fault(f"expected the shape {shape}, got {array.shape}")
        return array


def _kind(value: Any) -> str:
    names = {dict: "an object", list: "a list", str: "text", bool: "true or false", type(None): "null"}
    return names.get(type(value), repr(value))


def _animation(root: _Node) -> Animation:
    if not isinstance(root.value, dict) or root.value.get("format") != FORMAT:
        raise InputError(f"{root.path} is not a {FORMAT} file: it holds other JSON")
    version = root.get("version").whole()
    if version != VERSION:
        raise InputError(f"{root.path} is {FORMAT} version {version}; this mien reads version {VERSION}: update mien")
    origin = root.get("provenance")
    try:
        return Animation(
            channels=_channels(root.get("channels")),
            markers=None if root.get("markers").value is None else _markers(root.get("markers")),
            utterance=_utterance(root.get("utterance")),
            score=_score(root.get("score")),
            provenance=Provenance(
                origin.get("performer").text(), origin.get("seed").whole(), origin.get("version").text()
            ),
            notes=_notes(root.get("notes")),
            edits=_edits(root.get("edits"), root) if root.holds("edits") else None,
            timecode=root.get("timecode").text() if root.holds("timecode") else "",
        )
    except InputError as problem:  # the types themselves refuse what does not hold together: say in which file
        if str(problem).startswith(str(root.path)):
            raise
        raise InputError(f"{root.path}: {problem}") from problem


def _rate(node: _Node) -> FrameRate:
    try:
        fraction = fraction_of(node.text(), "rate")
    except InputError as problem:
        raise node.fault(f"expected a frame rate such as '25' or '30000/1001', got {node.value!r}") from problem
    if not 0 < fraction <= MAX_FPS:
        raise node.fault(f"a frame rate is above 0 and at most {MAX_FPS}, not {node.value}")
    return FrameRate(fraction)


def _names(node: _Node) -> list[str]:
    return [name.text() for name in node.items()]


def _frames(node: _Node) -> int:
    frames = node.whole()
    if frames < 0:
        raise node.fault(f"expected a number of frames, got {frames}")
    return frames


def _channels(node: _Node) -> ChannelTrack:
    names = _names(node.get("names"))
    values = node.get("values").array((_frames(node.get("frames")), len(names)))
    return ChannelTrack(names, values, _rate(node.get("rate")))


def _markers(node: _Node) -> MarkerTrack:
    names = _names(node.get("names"))
    positions = node.get("positions").array((_frames(node.get("frames")), len(names), 3))
    return MarkerTrack(names, positions, _rate(node.get("rate")))


def _tier(node: _Node) -> Tier:
    def interval(item: _Node) -> Interval:
        parts = item.items()
        if len(parts) != 3:
            raise item.fault(f"an interval is [start, end, label], got {len(parts)} things")
        return Interval(parts[0].number(), parts[1].number(), parts[2].text())

    return Tier(node.get("name").text(), tuple(interval(item) for item in node.get("intervals").items()))


def _score(node: _Node) -> Score:
    emotions = tuple(_emotion(span) for span in node.get("emotions").items())
    # files of mien 0.1 may have neither curves nor efforts
    curves = tuple(_curve(curve) for curve in node.get("curves").items()) if "curves" in node.value else ()
    efforts = tuple(_effort(span) for span in node.get("efforts").items()) if "efforts" in node.value else ()
    return Score(emotions, curves, efforts)


def _edits(node: _Node, root: _Node) -> AppliedEdits:
    before, frames = node.get("before"), _frames(root.get("channels").get("frames"))
    layer = layer_of(node.get("layer").value, f"{node.path}: {node.get('layer').place}")
    lost = tuple(_loss(loss, len(layer.edits)) for loss in node.get("lost").items())
    if not isinstance(before.get("channels").value, dict):
        raise before.get("channels").fault("expected an object")
    channels = {name: before.get("channels").get(name).array((frames,)) for name in before.get("channels").value}
    native = _tier(before.get("native")) if before.holds("native") else None
    emotions = tuple(_emotion(span) for span in before.get("emotions").items())
    return AppliedEdits(
        layer, lost, Before(_tier(before.get("words")), _tier(before.get("phones")), native, emotions, channels)
    )


def _loss(node: _Node, edits: int) -> Lost:
    point = None if node.get("point").value is None else node.get("point").whole()
    if not 0 <= node.get("edit").whole() < edits:
        raise node.get("edit").fault(f"the layer has {edits} edits")
    return Lost(node.get("edit").whole(), point, node.get("why").text())


def _curve(node: _Node) -> ParameterCurve:
    keys = [[number.number() for number in key.items()] for key in node.get("keys").items()]
    if any(len(key) != 2 for key in keys):
        raise node.get("keys").fault("a key is [milliseconds, value]")
    return ParameterCurve(
        node.get("parameter").text(),
        tuple((key[0], key[1]) for key in keys),
        node.get("interpolation").text(),
        cast(Any, node.get("mode").text()),
        node.get("fade").number(),
        tuple(name.text() for name in node.get("tangents").items()) if node.holds("tangents") else (),
    )


def _emotion(node: _Node) -> EmotionSpan:
    strength = _strength(node.get("intensity"), IntensityCurve)
    return EmotionSpan(node.get("name").text(), strength, _time(node.get("start")), _time(node.get("end")))


def _effort(node: _Node) -> EffortSpan:
    source = cast(Any, node.get("source").one_of("asked", "voice", "off"))
    level = _strength(node.get("level"), EffortCurve)
    return EffortSpan(level, _time(node.get("start")), _time(node.get("end")), source)


def _time(node: _Node) -> float | None:
    return None if node.value is None else node.number()


def _strength(node: _Node, kind: type[Curve]) -> float | Curve:
    if not isinstance(node.value, dict):
        return node.number()
    times, values = (tuple(item.number() for item in node.get(key).items()) for key in ("times", "values"))
    return kind(times, values, cast(Any, node.get("interpolation").one_of("smooth", "linear")))


def _notes(node: _Node) -> tuple[Note, ...]:
    def note(item: _Node) -> Note:
        kind = item.get("kind").one_of("note", "warning")
        return Note(cast(Any, kind), item.get("message").text())

    return tuple(note(item) for item in node.items())


def _audio(node: _Node) -> Audio:
    rate, count, data = node.get("rate").whole(), node.get("samples").whole(), node.get("data")
    try:
        return decode_audio(data.text(), rate, count)
    except InputError as problem:
        raise data.fault(str(problem)) from problem


def _utterance(node: _Node) -> Utterance:
    timing = node.get("timing").one_of("aligned", "recognised", "voice", "given", "none")
    return Utterance(
        text=node.get("text").text(),
        audio=_audio(node.get("audio")),
        words=_tier(node.get("words")),
        phones=_tier(node.get("phones")),
        language=node.get("language").text(),
        timing=cast(Any, timing),
        notes=_notes(node.get("notes")),
        native=_tier(node.get("native")) if node.holds("native") else None,
        shapes=tuple(tuple(_names(item)) for item in node.get("shapes").items()) if node.holds("shapes") else (),
        sung=node.get("sung").truth() if node.holds("sung") else False,
    )
