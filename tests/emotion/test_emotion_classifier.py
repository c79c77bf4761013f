from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

from mien.core.audio import Audio
from mien.core.errors import InputError
from mien.corpus.labelled_sounds import LabelledSound, LabelledSounds
from mien.emotion.emotion_classifier import (
    MOST_NEUTRAL_WRONG,
    EmotionClassifier,
    _thresholds,
    default_classifier,
    load_classifier,
)
from mien.emotion.emotion_over_time import RunningBaseline, emotion_spans, likeliest_course, read_over_time
from mien.emotion.emotion_samples import emotion_samples
from mien.formats.sound_files import read_audio
from mien.speech.sound_variations import varied
from mien.speech.voice_features import analyse, voice_features

RATE = 16_000


def talk(mood: str, seed: int, seconds: float = 1.5) -> Audio:
    """Syllables of a buzz: high, fast and lively, or low, slow and flat."""
    random = np.random.default_rng(seed)
    pace, pitch, swing = {"angry": (6.0, 220, 6.0), "lively": (4.8, 175, 4.0), "neutral": (3.0, 120, 1.0)}[mood]
    t = np.arange(round(seconds * RATE)) / RATE
    semitones = swing * np.sin(2 * np.pi * random.uniform(0.5, 1.0) * t + random.uniform(0, 6))
    phase = 2 * np.pi * np.cumsum(pitch * random.uniform(0.9, 1.1) * 2 ** (semitones / 12)) / RATE
    buzz = sum(np.sin(k * phase) / k ** {"angry": 1.0, "lively": 1.3, "neutral": 1.8}[mood] for k in range(1, 12))
    envelope = 0.1 + np.clip(np.sin(np.pi * pace * t + random.uniform(0, 3)), 0, None)
    return Audio(0.1 * buzz * envelope + random.normal(0, 1e-3, len(t)), RATE)


@pytest.fixture(scope="module")
def learned(tmp_path_factory: pytest.TempPathFactory) -> EmotionClassifier:
    folder = tmp_path_factory.mktemp("voices")
    sounds = []
    for number in range(24):
        mood = ("angry", "neutral")[number % 2]
        path = folder / f"{number}.wav"
        talk(mood, number, 1.5 + number % 3 / 2).write(path)
        sounds.append(LabelledSound(path, mood, f"s{number % 4 // 2}{number % 3}"))
    corpus = LabelledSounds("made up", tuple(sounds))
    return EmotionClassifier(kernel="linear", cost=0.1).fit(emotion_samples(corpus, variations=1))


def test_moods_of_unheard_voices_are_told(learned: EmotionClassifier) -> None:
    for seed in range(100, 106):
        assert learned.read(talk("angry", seed)).emotion == "angry"
        assert learned.read(talk("neutral", seed)).emotion == "neutral"


def test_a_stirred_voice_has_more_intensity(learned: EmotionClassifier) -> None:
    stirred, calm = learned.read(talk("angry", 50)), learned.read(talk("neutral", 50))
    assert stirred.activation > calm.activation + 0.3
    assert 0.4 <= stirred.intensity <= 1
    assert calm.intensity == 0


def test_saved_and_loaded_it_says_the_same(learned: EmotionClassifier, tmp_path: Path) -> None:
    learned.save(tmp_path / "a.npz")
    learned.save(tmp_path / "b.npz")
    assert (tmp_path / "a.npz").read_bytes() == (tmp_path / "b.npz").read_bytes()
    sound = talk("angry", 7)
    assert load_classifier(tmp_path / "a.npz").read(sound) == learned.read(sound)


@pytest.mark.parametrize("content", [b"", b"PK nonsense", None])
def test_what_is_no_classifier_is_refused(tmp_path: Path, content: bytes | None) -> None:
    path = tmp_path / "x.npz"
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(InputError, match=r"x\.npz"):
        load_classifier(path)


@pytest.mark.parametrize("sound", [Audio.silence(2.0, RATE), Audio.silence(0.0, RATE), talk("angry", 1, 0.2)])
def test_without_speech_nothing_is_claimed(sound: Audio) -> None:
    reading = default_classifier().read(sound)
    assert (reading.emotion, reading.intensity, reading.is_sure) == ("neutral", 0.0, False)


def test_the_default_never_returns_what_it_was_not_taught() -> None:
    assert default_classifier().emotions == ("afraid", "angry", "disgusted", "happy", "neutral", "sad")


@pytest.mark.parametrize("change", ["quiet", "rate", "silence"])
def test_level_rate_and_silence_around_change_little(change: str) -> None:
    sound = talk("angry", 3)
    other = {
        "quiet": lambda: Audio(sound.samples * 0.02, RATE),
        "rate": lambda: sound.resampled(48_000),
        "silence": lambda: Audio.join([Audio.silence(1.0, RATE), sound, Audio.silence(1.0, RATE)]),
    }[change]()
    before, after = (np.array(list(voice_features(analyse(s)).values())) for s in (sound, other))
    used, spread = default_classifier().columns_, default_classifier().machine_.scale_
    assert np.median(np.abs(after - before)[used] / spread) < 0.05


def test_features_have_the_same_names_for_every_sound() -> None:
    sounds = [Audio.silence(0.5, RATE), talk("angry", 1, 0.1), talk("neutral", 2), varied(talk("angry", 3),
              np.random.default_rng(0))]  # fmt: skip
    names = [list(voice_features(analyse(sound))) for sound in sounds]
    assert all(found == names[0] for found in names)
    assert all(np.isfinite(list(voice_features(analyse(sound)).values())).all() for sound in sounds)


def test_a_variation_depends_on_its_seed_alone() -> None:
    one, two, other = (varied(talk("angry", 1), np.random.default_rng(seed)) for seed in (4, 4, 5))
    assert one == two
    assert one != other


def test_a_change_of_mood_is_placed_in_time(learned: EmotionClassifier) -> None:
    sound = Audio.join([talk("neutral", 1, 6.0), Audio.silence(0.3, RATE), talk("angry", 2, 6.0)])
    stretches = read_over_time(sound, learned)
    assert [s.reading.emotion for s in stretches] == ["neutral", "angry"]
    assert stretches[0].start == 0
    assert stretches[0].end == stretches[1].start == pytest.approx(6.15, abs=0.7)
    assert stretches[1].end == sound.duration
    (span,) = emotion_spans(sound, learned)
    assert (span.name, span.start, span.end) == ("angry", stretches[1].start, None)


def test_intensity_follows_the_voice(learned: EmotionClassifier) -> None:
    """The same talk, its second half 12 dB softer."""
    loud = talk("angry", 2, 3.0)
    sound = Audio.join([loud, Audio(loud.samples * 0.25, RATE)])
    spans = emotion_spans(sound, learned)
    assert [span.name for span in spans] == ["angry"]
    early, late = spans[0].intensity_at(np.arange(0.25, 6, 0.25)).reshape(-1)[:22].reshape(2, 11).mean(axis=1)
    assert early > late + 0.05


def test_one_odd_window_is_no_change() -> None:
    calm, stirred = [0.9, 0.1], [0.2, 0.8]
    assert likeliest_course(np.array([calm, calm, stirred, calm])).tolist() == [0, 0, 0, 0]
    assert likeliest_course(np.array([calm] * 4 + [stirred] * 6)).tolist() == [0] * 4 + [1] * 6


def test_together_takes_out_what_the_sounds_share(learned: EmotionClassifier) -> None:
    moods: Sequence[str] = ["angry", "neutral"] * 4
    readings = learned.read_together([talk(mood, 60 + i) for i, mood in enumerate(moods)])
    assert [reading.emotion for reading in readings] == list(moods)


def test_a_speaker_is_judged_against_their_own_neutral_voice(learned: EmotionClassifier) -> None:
    """Somebody whose calm voice is lively: alone it sounds more stirred than against their own."""
    calm = [talk("lively", 200 + i) for i in range(8)]
    sound = talk("lively", 300)
    alone, against = learned.read(sound), learned.read(sound, baseline=calm)
    assert against.probabilities["neutral"] > alone.probabilities["neutral"] + 0.1
    assert against.activation < alone.activation


def test_a_baseline_counts_more_the_more_of_it_was_heard(learned: EmotionClassifier) -> None:
    others = np.ones((50, len(learned.usual_))) + learned.usual_
    off = [np.abs(learned.baseline_of(others[:n]) - learned.usual_).max() for n in (0, 1, 3, 50)]
    assert off == pytest.approx([0, 1 / 4, 3 / 6, 50 / 53])


def test_a_baseline_without_speech_does_not_count(learned: EmotionClassifier) -> None:
    sound = talk("angry", 7)
    assert learned.read(sound, baseline=[Audio.silence(1.0, RATE)]) == learned.read(sound)


def test_calm_parts_of_a_recording_become_its_measure_stirred_ones_do_not(learned: EmotionClassifier) -> None:
    def moved(mood: str) -> float:
        rows = np.array([list(voice_features(analyse(talk(mood, 400 + i, 2.5))).values()) for i in range(6)])
        running = RunningBaseline(learned, learned.usual_)
        running.add(rows)
        moved = running.value - learned.usual_
        return float(np.abs(moved[learned.columns_] / learned.machine_.scale_).mean())

    assert moved("neutral") > 4 * moved("angry")


def test_few_neutral_recordings_pass_a_threshold(learned: EmotionClassifier) -> None:
    from types import SimpleNamespace

    random = np.random.default_rng(5)
    sure = np.concatenate([random.uniform(0.3, 0.8, 400), random.uniform(0.4, 1.0, 400)])
    machine = SimpleNamespace(classes_=("angry", "neutral"), held_out_probabilities_=np.stack([sure, 1 - sure], axis=1))
    threshold = _thresholds(machine, ["neutral"] * 400 + ["angry"] * 400)["angry"]  # type: ignore[arg-type]
    given = (sure >= threshold) & (sure > 0.5)
    assert given[:400].mean() <= MOST_NEUTRAL_WRONG
    assert threshold == pytest.approx(0.8, abs=0.02)


def test_a_file_of_the_first_version_still_reads(learned: EmotionClassifier, tmp_path: Path) -> None:
    import json
    import zipfile

    learned.save(tmp_path / "new.npz")
    with zipfile.ZipFile(tmp_path / "new.npz") as new, zipfile.ZipFile(tmp_path / "old.npz", "w") as old:
        head = json.loads(new.read("classifier.json"))
        head["version"], head["threshold"] = 1, 0.54
        del head["thresholds"]
        for name in new.namelist():
            if name not in ("classifier.json", "columns.npy", "usual.npy", "from_neutral.npy"):
                old.writestr(name, new.read(name))
        old.writestr("classifier.json", json.dumps(head))
    loaded = load_classifier(tmp_path / "old.npz")
    assert loaded.thresholds_ == {"angry": 0.54, "neutral": 0.54}
    assert not loaded.usual_.any()


def test_speakers_of_one_mood_are_compared_with_everybody(tmp_path: Path) -> None:
    sounds = []
    for number in range(12):
        path = tmp_path / f"{number}.wav"
        talk(("angry", "neutral")[number % 2], number).write(path)
        sounds.append(LabelledSound(path, ("angry", "neutral")[number % 2], f"only-{number % 2}-{number % 3}"))
    learned = EmotionClassifier(kernel="linear").fit(emotion_samples(LabelledSounds("x", tuple(sounds))))
    assert learned.read(talk("angry", 40)).most_likely == "angry"
    assert learned.read(talk("neutral", 40)).most_likely == "neutral"


def test_other_features_are_refused(learned: EmotionClassifier) -> None:
    with pytest.raises(InputError, match="features are"):
        emotion_samples(LabelledSounds("x", ()), "mfcc")


@pytest.mark.data
def test_the_shipped_classifier_knows_its_corpus(shared_data: Path) -> None:
    files = sorted((shared_data / "emodb" / "audio").glob("03*[WTN]?.flac"))[::4]
    named = {"W": "angry", "T": "sad", "N": "neutral"}
    right = [default_classifier().read(read_audio(path)[0]).most_likely == named[path.stem[5]] for path in files]
    assert np.mean(right) > 0.9


@pytest.mark.data
def test_neutral_speech_of_another_corpus_mostly_stays_neutral(shared_data: Path) -> None:
    files = sorted((shared_data / "grid-s1" / "audio").glob("*.flac"))[::45]
    kept = [default_classifier().read(read_audio(path)[0]).emotion == "neutral" for path in files]
    assert np.mean(kept) > 0.6


def test_noise_is_no_voice(learned: EmotionClassifier) -> None:
    noise = Audio(0.1 * np.random.default_rng(3).normal(size=2 * RATE), RATE)
    reading = learned.read(noise)
    assert (reading.emotion, reading.seconds, reading.probabilities["neutral"]) == ("neutral", 0.0, 1.0)
