from __future__ import annotations

import numpy as np
import pytest

from mien.core import channels
from mien.core.errors import InputError
from mien.core.timeline import FrameRate
from mien.face.library import load_face
from mien.face.posing import Poser
from mien.motion.mouth.learned_mouth import LearnedMouth
from mien.motion.mouth.speech_model import synthesise
from mien.motion.performers import known_performers, load_learned_performer, load_performer
from mien.text.normalisation import pronounce_text
from mien.text.phones import phone_table
from tests.utterances import utterance

# Twenty sentences; every phone of English is in them, and plenty of lips.
SENTENCES = (
    "She chose the rouge version.",
    "Oil the hinges, good singer.",
    "Papa may buy five very good mauve vans.",
    "Bob's baby bumped his thumb.",
    "We were away a year ago.",
    "Five fluffy foxes leave the village.",
    "Move the azure vase above the beige sofa.",
    "Thirty thin brothers breathe with both lungs.",
    "Judge the huge orange by its juice.",
    "How now, brown cow?",
    "The boy enjoys noisy toys.",
    "Look, the cook took a good book.",
    "Mum made warm plum jam.",
    "Please pass the peppered beef pie.",
    "Why would you wait until Wednesday?",
    "Sixty-six cheap chips.",
    "I never said that.",
    "Hang the long ring on the string.",
    "Robert prefers a nervous nurse.",
    "Which fish would Josh wish for?",
)
RATE = FrameRate.of(60)
PAIRS = ["", *(f"_{side}{step}" for side in "lr" for step in (1, 2))]


@pytest.fixture(scope="module")
def mouth() -> LearnedMouth:
    return LearnedMouth(load_learned_performer("default"))


def phones_of(sentence: str) -> list[tuple[str, float]]:
    """Phones at an even, brisk pace with pauses around them."""
    said = [phone for _, phones in pronounce_text(sentence) for phone in phones]
    return [("SIL", 0.3), *((phone, 0.075) for phone in said), ("SIL", 0.3)]


def test_the_sentences_hold_every_phone() -> None:
    said = {phone for sentence in SENTENCES for phone, _ in phones_of(sentence)}
    assert said >= set(phone_table())


@pytest.mark.parametrize("sentence", SENTENCES)
def test_inner_lips_never_pass_through_each_other(mouth: LearnedMouth, sentence: str) -> None:
    motion = mouth.perform(utterance(*phones_of(sentence)), RATE)
    face = load_face("default")
    poser = Poser(face, channels.ALL)
    for row in motion.values:
        posed = dict(zip((part.name for part in face.parts), poser.pose(row).parts, strict=True))
        for pair in PAIRS:
            (part, upper_vertex), (_, lower_vertex) = (face.sites[f"lip_{s}_inner{pair}"] for s in ("upper", "lower"))
            inner = posed[part].vertices[:, 1]
            # The default face's lips touch at rest with their sites up to 0.3 mm past each other.
            assert inner[upper_vertex] - inner[lower_vertex] > -1.0


def test_weights_are_in_range_for_any_phones(mouth: LearnedMouth) -> None:
    motion = mouth.perform(utterance(*((phone, 0.05) for phone in phone_table())), RATE)
    assert motion.values.min() >= 0
    assert motion.values.max() <= 1
    still = [channels.ALL.index(name) for name in channels.UPPER_FACE + channels.HEAD]
    assert not motion.values[:, still].any()


def test_hand_made_shapes_serve_only_what_was_never_recorded(mouth: LearnedMouth) -> None:
    assert set(mouth.hand_made_phones) == {"NG", "SH", "ZH"}
    line = utterance(
        ("SIL", 0.2), ("AA", 0.2), ("T", 0.1), ("UW", 0.2), ("T", 0.1), ("SH", 0.3), ("AA", 0.2), ("SIL", 0.2)
    )
    motion = mouth.perform(line, RATE)
    times = RATE.times(len(motion.values))
    own = mouth.on_face(synthesise(mouth.speech, line.phones, times, line.audio), RATE)
    by_hand = mouth.hand_made.perform(line, RATE).values
    tongue = [channels.ALL.index(name) for name in (*channels.TONGUE, "tongueOut")]
    lips = [i for i in range(len(channels.ALL)) if i not in tongue]
    recorded, unheard = (times > 0.2) & (times < 0.75), np.abs(times - 0.95) < 0.02
    assert motion.values[recorded][:, lips] == pytest.approx(own[recorded][:, lips])
    assert motion.values[unheard] == pytest.approx(by_hand[unheard], abs=1e-6)
    assert motion.values[:, tongue] == pytest.approx(by_hand[:, tongue])


def test_vowels_open_and_rounded_vowels_narrow_the_mouth(mouth: LearnedMouth) -> None:
    motion = mouth.perform(utterance(("SIL", 0.3), ("AA", 0.3), ("T", 0.1), ("UW", 0.3), ("SIL", 0.3)), RATE)
    jaw, pucker = (motion.values[:, channels.ALL.index(name)] for name in ("jawOpen", "mouthPucker"))
    assert 0.3 < RATE.time_of(int(np.argmax(jaw))) < 0.65
    assert 0.65 < RATE.time_of(int(np.argmax(pucker))) < 1.05


def test_what_is_out_of_range_or_unknown_is_refused() -> None:
    learned = load_learned_performer("default")
    with pytest.raises(InputError, match="unknown speech model"):
        LearnedMouth(learned, speech_model="mumbling")
    with pytest.raises(InputError, match="did you mean 'default'"):
        load_performer("defualt")
    with pytest.raises(InputError, match=r"nobody\.mien"):
        load_performer("nobody.mien")
    assert known_performers() == ("hand-made", "default", "mandarin")
