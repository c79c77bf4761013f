"""The native file keeps everything, and refuses what does not hold together."""

from __future__ import annotations

import dataclasses
import json
import math
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as nps

from mien.animation.animation import Animation, Provenance
from mien.animation.edits import AppliedEdits, EditLayer, Lost
from mien.animation.edits.applied import Before
from mien.core.audio import Audio
from mien.core.errors import InputError, Note, OutputError
from mien.core.timeline import FrameRate, Interval, Tier
from mien.core.tracks import ChannelTrack, MarkerTrack
from mien.core.utterance import Utterance
from mien.formats.native import read_native, write_native
from mien.text.intensity import IntensityCurve
from mien.text.key_tangents import TANGENTS
from mien.text.parameter_curves import INTERPOLATIONS, MODES, ParameterCurve
from mien.text.score import EmotionSpan, Score
from tests.animation.edits.layers import layers
from tests.faces import tiny_animation

finite = st.floats(allow_nan=False, allow_infinity=False)
times = st.floats(-5, 1e4)
texts = st.text(st.characters(exclude_categories=["Cs"]), max_size=12)
rates = st.fractions(Fraction(1, 100), 1000).map(FrameRate)
notes = st.lists(st.builds(Note, st.sampled_from(["note", "warning"]), texts), max_size=2).map(tuple)
names = st.lists(texts, max_size=4, unique=True)


@st.composite
def tiers(draw):
    edges = sorted(draw(st.lists(times, max_size=8)))
    pairs = zip(edges[::2], edges[1::2], strict=False)
    return Tier(draw(texts), tuple(Interval(start, end, draw(texts)) for start, end in pairs))


@st.composite
def channel_tracks(draw):
    columns = draw(names)
    shape = (draw(st.integers(0, 4)), len(columns))
    return ChannelTrack(columns, draw(nps.arrays(np.float64, shape, elements=finite)), draw(rates))


@st.composite
def marker_tracks(draw):
    markers = draw(names)
    shape = (draw(st.integers(0, 3)), len(markers), 3)
    numbers = st.floats(allow_nan=True, allow_infinity=False)
    return MarkerTrack(markers, draw(nps.arrays(np.float64, shape, elements=numbers)), draw(rates))


sounds = st.builds(
    Audio,
    st.lists(st.floats(-1.5, 1.5), max_size=40),
    st.integers(1000, 384_000),
)
curves_of_intensity = st.dictionaries(st.integers(0, 50), st.floats(0, 1), min_size=1, max_size=5).map(
    lambda points: IntensityCurve(
        tuple(float(time) for time in sorted(points)), tuple(points[t] for t in sorted(points))
    )
)
spans = st.builds(
    lambda name, intensity, edges: EmotionSpan(name, intensity, *edges),
    texts,
    st.floats(0, 1) | curves_of_intensity,
    st.tuples(times, times).map(sorted) | st.tuples(st.none(), times) | st.tuples(times, st.none()),
)
curves = st.builds(
    lambda name, keys, how, mode, fade, tangent: ParameterCurve(
        name, keys, how, mode, fade, (tangent,) * len(keys) if tangent else ()
    ),
    st.sampled_from(["HeadNod", "jawOpen", "mouthSmile"]),
    st.lists(st.tuples(times, finite), min_size=1, max_size=4).map(lambda keys: tuple(sorted(keys))),
    st.sampled_from(INTERPOLATIONS),
    st.sampled_from(MODES),
    st.floats(0, 1000),
    st.none() | st.sampled_from(TANGENTS),
)
utterances = st.builds(
    Utterance,
    texts,
    sounds,
    tiers(),
    tiers(),
    texts,
    st.sampled_from(["aligned", "recognised", "voice", "none"]),
    notes,
)
plain_animations = st.builds(
    Animation,
    channel_tracks(),
    st.none() | marker_tracks(),
    utterances,
    st.builds(Score, st.lists(spans, max_size=3).map(tuple), st.lists(curves, max_size=2).map(tuple)),
    st.builds(Provenance, texts, st.integers(), texts),
    notes,
)


@st.composite
def edited_animations(draw):
    """Animations, some with a layer of edits on them."""
    animation, layer = draw(plain_animations), draw(st.none() | layers.filter(lambda layer: layer.edits))
    if layer is None:
        return animation
    lost = st.builds(Lost, st.integers(0, len(layer.edits) - 1), st.none() | st.integers(0, 9), texts)
    columns = {name: animation.channels.channel(name) for name in animation.channels.names[:2]}
    before = Before(
        draw(tiers()), draw(tiers()), draw(st.none() | tiers()), tuple(draw(st.lists(spans, max_size=2))), columns
    )
    edits = AppliedEdits(layer, tuple(draw(st.lists(lost, max_size=2))), before)
    return dataclasses.replace(animation, edits=edits)


animations = edited_animations()


@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large])
@given(animation=animations)
def test_round_trip(tmp_path_factory, animation):
    path = tmp_path_factory.mktemp("native") / "a.json"
    assert write_native(animation, path) == ()
    assert read_native(path) == animation


@pytest.mark.parametrize("rate", [1000, 8000, 11025, 44100, 65537, 192_000, 191_999, 384_000])
def test_sound_is_exact_at_every_rate(tmp_path, rate):
    rng = np.random.default_rng(0)
    sound = Audio(np.r_[-1.0, 1 - 2**-23, rng.uniform(-1, 1, 300)], rate)
    animation = dataclasses.replace(
        tiny_animation(), utterance=dataclasses.replace(tiny_animation().utterance, audio=sound)
    )
    write_native(animation, tmp_path / "a.json")
    again = read_native(tmp_path / "a.json").utterance.audio
    assert again.rate == rate
    assert again.samples.tobytes() == sound.samples.tobytes()


def test_every_field_is_written():
    """A field added to one of these types needs a place in the schema: add it there, then here."""
    known = {
        Animation: {"channels", "markers", "utterance", "score", "provenance", "notes", "edits", "timecode"},
        Utterance: {"text", "audio", "words", "phones", "language", "timing", "notes", "native", "shapes", "sung"},
        Score: {"emotions", "curves", "efforts"},
        ParameterCurve: {"parameter", "keys", "interpolation", "mode", "fade", "tangents"},
        EmotionSpan: {"name", "intensity", "start", "end"},
        Provenance: {"performer", "seed", "version"},
        AppliedEdits: {"layer", "lost", "before"},
        Before: {"words", "phones", "native", "emotions", "channels"},
        Lost: {"edit", "point", "why"},
        EditLayer: {"edits", "line", "emotions"},
        Note: {"kind", "message"},
    }
    for kind, fields in known.items():
        assert {field.name for field in dataclasses.fields(kind)} == fields, kind


@pytest.fixture
def document(tmp_path):
    write_native(tiny_animation(4), tmp_path / "a.json")
    return json.loads((tmp_path / "a.json").read_text(encoding="utf-8"))


def refused(tmp_path, text: str) -> str:
    path = tmp_path / "bad.json"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(InputError) as caught:
        read_native(path)
    assert "bad.json" in str(caught.value)
    assert "\n" not in str(caught.value)
    return str(caught.value)


def test_wrong_files(tmp_path, document):
    assert "cut short" in refused(tmp_path, json.dumps(document)[:-40])
    assert "cut short" in refused(tmp_path, "")
    assert "other JSON" in refused(tmp_path, "[1, 2]")
    assert "other JSON" in refused(tmp_path, '{"asset": {"version": "2.0"}}')
    assert "version 2" in refused(tmp_path, json.dumps(document | {"version": 2}))
    (tmp_path / "noise.json").write_bytes(bytes(range(256)))
    with pytest.raises(InputError, match="UTF-8"):
        read_native(tmp_path / "noise.json")
    with pytest.raises(InputError, match="no such file"):
        read_native(tmp_path / "none.json")


BREAKS = {
    "channels.values: expected the shape (4, 71), got (3, 71)": lambda d: d["channels"]["values"].pop(),
    "channels.values: expected numbers": lambda d: d["channels"]["values"][1].pop(),
    "channels.rate": lambda d: d["channels"].update(rate="0"),
    "channels.frames: expected a whole number": lambda d: d["channels"].update(frames="4"),
    "names repeat": lambda d: d["channels"]["names"].__setitem__(0, "jawOpen"),
    "in frame 2": lambda d: d["channels"]["values"][2].__setitem__(0, None),
    "markers.positions": lambda d: d["markers"]["positions"][0].pop(),
    "the field 'phones' is missing": lambda d: d["utterance"].pop("phones"),
    "the whole file: the field 'score' is missing": lambda d: d.pop("score"),
    "utterance.timing: expected one of": lambda d: d["utterance"].update(timing="guessed"),
    "utterance.words.intervals[0]": lambda d: d["utterance"]["words"]["intervals"][0].pop(),
    "utterance.words.intervals[0][1]: expected a finite number": lambda d: d["utterance"]["words"]["intervals"][
        0
    ].__setitem__(1, "x"),
    "run forward": lambda d: d["utterance"]["words"]["intervals"][0].__setitem__(1, -1.0),
    "samples of sound": lambda d: d["utterance"]["audio"].update(samples=1),
    "not base64": lambda d: d["utterance"]["audio"].update(data="!!!!"),
    "not FLAC": lambda d: d["utterance"]["audio"].update(data="AAAA"),
    "sample rate": lambda d: d["utterance"]["audio"].update(rate=5),
    "0 to 1": lambda d: d["score"]["emotions"][0].update(intensity=7),
    "notes[0].kind": lambda d: d["notes"][0].update(kind="shout"),
    "provenance.seed: expected a whole number": lambda d: d["provenance"].update(seed=True),
    "utterance: expected an object, got a list": lambda d: d.update(utterance=[]),
}


@pytest.mark.parametrize("message", BREAKS)
def test_broken_files_name_the_place(tmp_path, document, message):
    BREAKS[message](document)
    assert message in refused(tmp_path, json.dumps(document))


def test_infinite_marker_is_refused(tmp_path):
    markers = MarkerTrack(("chin",), [[[math.inf, 0, 0]]], FrameRate.of(25))
    with pytest.raises(OutputError, match="'chin' is infinitely far away in frame 0"):
        write_native(dataclasses.replace(tiny_animation(), markers=markers), tmp_path / "a.json")
