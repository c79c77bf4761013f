"""Lines, layers and takes for tests of the edits."""

from __future__ import annotations

from hypothesis import strategies as st

from mien.animation.edits import Anchor, BorderEdit, ChannelEdit, EditLayer, IntensityEdit, LineWord, Place
from mien.animation.edits.layer import channel_range
from mien.core import channels
from mien.core.audio import Audio
from mien.core.timeline import Interval, Tier
from mien.core.utterance import Utterance
from mien.text.key_tangents import TANGENTS
from mien.text.parameter_curves import INTERPOLATIONS

PHONES = ("N", "EH", "V", "ER", "S", "D", "AE", "T")
WORDS = {"i": ("AY",), "never": ("N", "EH", "V", "ER"), "said": ("S", "EH", "D"), "that": ("DH", "AE", "T")}
EMOTIONS = ("happy", "sad", "angry")


def spoken(*entries: tuple[str, tuple[str, ...], float] | float, phone: float = 0.1, text: str = "") -> Utterance:
    """Words as (label, phones, seconds for each phone) and pauses as seconds, one after another."""
    now, phones, words = 0.0, [], []
    for entry in entries:
        if isinstance(entry, float):
            phones.append(Interval(now, now + entry, "SIL"))
        else:
            label, own, length = entry
            first = now
            for name in own:
                phones.append(Interval(now, now + length, name))
                now += length
            words.append(Interval(first, now, label))
        now = phones[-1].end
    audio = Audio.silence(now, 16_000)
    return Utterance(text, audio, Tier("words", tuple(words)), Tier("phones", tuple(phones)), "en-US", "voice")


def say(text: str, length: float = 0.1, **phones: tuple[str, ...]) -> Utterance:
    """A pause, the words of a text (their phones from `WORDS`, or as given), and a pause."""
    words = text.split()
    known = {**WORDS, **phones}
    return spoken(0.2, *((word, known[word], length) for word in words), 0.3, text=text)


LINE = "i never said that i never said"


@st.composite
def places(draw, utterance: Utterance | None = None, pauses: bool = True):
    """Places in `LINE`, and some that are not in it."""
    if pauses and draw(st.integers(0, 5)) == 0:
        word = draw(st.sampled_from([None, "said", "never"]))
        return Place(word, 1, draw(st.integers(0, 1)), True)
    return Place(draw(st.sampled_from([*WORDS, "maybe"])), draw(st.integers(1, 3)), draw(st.integers(0, 4)))


anchors = st.builds(Anchor, places(), st.floats(0, 1))
borders = st.builds(BorderEdit, places(), st.sampled_from(["start", "end"]), st.floats(-0.5, 0.5))
tangents = st.none() | st.sampled_from(TANGENTS)


@st.composite
def passed(draw, value):
    """Points, and how the curve passes them."""
    points = draw(st.lists(st.tuples(anchors, value), min_size=1, max_size=5))
    asked = draw(st.just(()) | st.tuples(*(tangents for _ in points)))
    return tuple(points), asked if any(asked) else ()


@st.composite
def drawn_intensities(draw):
    points, passing = draw(passed(st.floats(0, 1)))
    return IntensityEdit(draw(st.sampled_from(EMOTIONS)), points, draw(st.sampled_from(["linear", "smooth"])), passing)


intensities = drawn_intensities()


@st.composite
def curves(draw):
    channel, mode = draw(st.sampled_from(channels.ALL)), draw(st.sampled_from(["add", "replace"]))
    least, most = channel_range(channel)
    keys, passing = draw(passed(st.floats(-most if mode == "add" else least, most)))
    return ChannelEdit(channel, mode, keys, draw(st.floats(0, 0.5)), draw(st.sampled_from(INTERPOLATIONS)), passing)


lines = st.lists(
    st.builds(
        LineWord,
        st.sampled_from(list(WORDS)),
        st.lists(st.sampled_from(PHONES), max_size=4).map(tuple),
        st.sampled_from([(), ("SIL",)]),
    ),
    max_size=6,
).map(lambda words: (LineWord(None, (), ("SIL",)), *words))
layers = st.builds(
    EditLayer,
    st.lists(borders | intensities | curves(), max_size=6).map(tuple),
    st.none() | lines,
    st.none() | st.lists(st.sampled_from(EMOTIONS), max_size=2, unique=True).map(tuple),
)
