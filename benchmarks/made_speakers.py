"""Performers of made speakers: does each learn its own way of speaking, seen by the real tracker?

::

    python benchmarks/made_speakers.py CORPUS CACHE [--takes 10] [--held-out 12] [-o docs/tables/made_speakers.md]

CORPUS is grid-s1, imported. Each made speaker has a head of its own from the space of heads and says what was recorded
in a style of its own (`STYLES`): the captured channels of a take, changed by the style, move the head, which is drawn
and tracked (``mien tracker install``) as a video of a person would be. From then on nothing is known but the pictures'
landmarks, the sound and the phones: the head is fitted, channels are captured, a performer is learned. It starts from
one that is learned as the default one is, but from none of these takes. CACHE keeps landmarks and that performer. A
speaker without a style, seen the same way, is what gains of styles are measured against.

A gain is the slope of what a performer does on what the plain speaker's does. What can be reached at all is told too:
how near the other speakers' own recordings of the same lines come.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from capture import made_head, slope, tracked  # benchmarks/capture.py, beside this file
from mien.capture.capture import capture_take
from mien.capture.one_camera import fit_speaker
from mien.core.audio import Audio
from mien.core.channels import ALL, WEIGHTS
from mien.core.files import replace_when_complete
from mien.core.timeline import Tier
from mien.core.tracks import ChannelTrack, MarkerTrack
from mien.core.utterance import PAUSE, Utterance
from mien.corpus.recordings import Corpus, identity_of
from mien.corpus.take import Take
from mien.face.model import Face
from mien.metrics import mouth
from mien.metrics.face_track import FaceTrack
from mien.metrics.pairing import constant_offset
from mien.motion.learning import LearningSettings, learn, learn_corpus
from mien.motion.mouth.learned_mouth import LearnedMouth
from mien.motion.performer_file import LearnedSpeech, load_learned, save_learned

DOCS = Path(__file__).parent.parent / "docs"
Floats = NDArray[np.float64]
ROUND = ("mouthPucker", "mouthFunnel")
SIDE = 320  # pixels of the pictures
EDGE = 0.24  # seconds before and after speech
UNDRAWN = ("hair", "hair_clumps", "shirt")
MOVED = ("mouth", "jaw", "eyeBlink")
SENTENCES = 44
RMS, IN_SPACE = "lips_rms_frontal_mm", "lips_rms_mm"
"""One camera guesses depth, and lips that protrude count as wrong in space: both are told."""
LATEST, STEP = 0.12, 0.005  # seconds: how late lips may be found


@dataclass(frozen=True)
class Style:
    """A head, and how its owner speaks beside the one who was recorded."""

    head: int
    jaw: float = 1.0
    rounding: float = 1.0
    late: float = 0.0  # seconds by which rounding and spreading of the lips come later

    def applied(self, weights: Floats, fps: float) -> Floats:
        """Channels of a take as this person moves, (frames, `WEIGHTS`)."""
        done = weights.copy()
        at = {name: place for place, name in enumerate(WEIGHTS)}
        opened = [at["jawOpen"], at["mouthClose"]]
        done[:, opened] *= self.jaw
        spread = [f"mouth{name}{side}" for name in ("Smile", "Stretch") for side in ("Left", "Right")]
        lips = [at[name] for name in (*ROUND, *spread)]
        frames = np.arange(len(done))
        for place in lips:
            done[:, place] = np.interp(frames - self.late * fps, frames, done[:, place])
        done[:, [at[name] for name in ROUND]] *= self.rounding
        return np.clip(done, 0.0, 1.0)


STYLES = {
    "plain": Style(11),
    "wide jaw, hardly round": Style(12, jaw=1.5, rounding=0.4),
    "small jaw, round, late lips": Style(13, jaw=0.65, rounding=2.2, late=0.06),
}


def spoken_part(take: Take) -> Take:
    """A take from `EDGE` seconds before its first phone to as long after its last one."""
    assert take.channels is not None
    rate, said = take.channels.rate, [phone for phone in take.phones if phone.label != PAUSE]
    first = max(0, int((said[0].start - EDGE) * rate.fps))
    after = min(len(take.channels.values), int(np.ceil((said[-1].end + EDGE) * rate.fps)))
    start, end = first / rate.fps, after / rate.fps

    def moved(tier: Tier) -> Tier:
        inside = [replace(p, start=max(p.start - start, 0.0), end=min(p.end, end) - start) for p in tier]
        return Tier(tier.name, tuple(p for p in inside if p.duration > 0))

    samples = take.audio.samples[round(start * take.audio.rate) : round(end * take.audio.rate)]
    return replace(
        take,
        audio=Audio(samples, take.audio.rate),
        markers=MarkerTrack(take.markers.names, take.markers.positions[first:after], rate),
        channels=ChannelTrack(take.channels.names, take.channels.values[first:after], rate),
        words=moved(take.words),
        phones=moved(take.phones),
        head=None,
    )


class Camera:
    """A made speaker in front of a camera."""

    def __init__(self, style: Style, cache: Path) -> None:
        self.style, self.cache = style, cache

    @cached_property
    def face(self) -> Face:
        """Without hair and clothes: a tracker needs neither, and drawing them takes longest."""
        face = made_head(self.style.head)
        return replace(face, parts=tuple(part for part in face.parts if part.name not in UNDRAWN))

    def seen(self, take: Take) -> MarkerTrack:
        """The take as the made speaker says it, drawn and tracked; kept in the cache."""
        assert take.channels is not None
        kept = self.cache / f"{self.style.head}-{take.name}.npz"
        if not kept.exists():
            weights = take.channels.select(WEIGHTS).values.copy()
            weights[:, [place for place, name in enumerate(WEIGHTS) if not name.startswith(MOVED)]] = 0.0
            track = tracked(self.face, self.style.applied(weights, take.channels.rate.fps), SIDE)
            with replace_when_complete(kept) as unfinished, unfinished.open("wb") as file:
                np.savez(file, positions=track.positions, names=np.array(track.names))
        stored = np.load(kept)
        return MarkerTrack(tuple(str(n) for n in stored["names"]), stored["positions"], take.channels.rate)


def takes_of(takes: Sequence[Take], style: Style, cache: Path) -> list[Take]:
    """What a corpus of the made speaker has: markers, and channels captured from them."""
    camera = Camera(style, cache)
    tracks = [camera.seen(take) for take in takes]
    person = fit_speaker(tracks[:30], "mediapipe-218")
    found = []
    for take, track in zip(takes, tracks, strict=True):
        own = replace(take, markers=track, speaker=str(style.head), channels=None, captured=False)
        found.append(replace(own, channels=capture_take(own, head=person, spoken=True).channels, captured=True))
    return found


def performed(speaker: LearnedMouth, take: Take) -> ChannelTrack:
    """What a performer does with the phones of a take."""
    line = Utterance(take.text, take.audio, take.words, take.phones, "en", "given")
    values = speaker.perform(line, take.markers.rate).values[: len(take.markers)]
    return ChannelTrack(ALL, values, take.markers.rate)


def distance(speaker: LearnedMouth, takes: Sequence[Take]) -> tuple[float, float, float]:
    """Of the face shown from a person's recordings: lips from the front and in space, mm, and r of the opening."""
    shown = [(FaceTrack.of_take(take), FaceTrack.of_channels(performed(speaker, take))) for take in takes]
    pairs = [mouth.mouth_pair(one, other)[0] for one, other in shown]
    offset = np.average([constant_offset(pair) for pair in pairs], axis=0, weights=[p.counted.sum() for p in pairs])
    scores = [mouth.evaluate(one, other, offset=offset) for one, other in shown]
    return tuple(float(np.mean([score[key] for score in scores])) for key in (RMS, IN_SPACE, "opening_r"))  # type: ignore[return-value]


def styled(speaker: LearnedMouth, plain: LearnedMouth, takes: Sequence[Take]) -> tuple[float, float, float]:
    """Gains of jaw and rounding, and lateness of rounding, of one performer beside another on the same lines."""
    own, other = ([performed(one, take) for take in takes] for one in (speaker, plain))

    def joined(tracks: Sequence[ChannelTrack], name: str) -> Floats:
        return np.concatenate([track.channel(name) for track in tracks])

    jaw = slope(joined(other, "jawOpen"), joined(own, "jawOpen"))
    puckers = joined(own, "mouthPucker"), joined(other, "mouthPucker")
    frames = np.arange(len(puckers[0]))
    fps = takes[0].markers.rate.fps
    lags = np.arange(-LATEST, LATEST + STEP / 2, STEP)
    later = [np.interp(frames - lag * fps, frames, puckers[1]) for lag in lags]
    best = int(np.argmax([np.corrcoef(puckers[0], other)[0, 1] for other in later]))
    return jaw, slope(later[best], puckers[0]), float(lags[best])


def started_from(corpus: Corpus, takes: Sequence[Take], cache: Path) -> LearnedSpeech:
    """A performer of the corpus that never met the takes; kept in the cache."""
    kept = cache / "start.mien"
    if not kept.exists():
        settings = LearningSettings(speech_model="coarticulation")
        spread = np.linspace(0, len(corpus) - 1, SENTENCES).astype(int)
        left_out = {corpus.names[place] for place in spread}
        save_learned(learn_corpus(corpus, settings, name="start", exclude_names=left_out), kept)
    start = load_learned(kept)
    assert not {identity_of(corpus.take(take.name)) for take in takes} & set(start.trained_on)
    return start


def recorded_apart(one: Sequence[Take], other: Sequence[Take]) -> float:
    """How near somebody else's recordings of the same lines come on the face, mm as in `distance`."""
    pairs = [
        mouth.mouth_pair(FaceTrack.of_take(a), FaceTrack.of_channels(b.channels))[0]
        for a, b in zip(one, other, strict=True)
        if b.channels is not None
    ]
    offset = np.average([constant_offset(pair) for pair in pairs], axis=0, weights=[p.counted.sum() for p in pairs])
    scores = [
        mouth.evaluate(FaceTrack.of_take(a), FaceTrack.of_channels(b.channels), offset=offset)[RMS]
        for a, b in zip(one, other, strict=True)
        if b.channels is not None
    ]
    return float(np.mean(scores))


def main() -> None:
    """Draw, track, learn, compare, write."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("corpus", type=Path)
    parser.add_argument("cache", type=Path)
    parser.add_argument("--takes", type=int, default=10)
    parser.add_argument("--held-out", type=int, default=12)
    parser.add_argument("-o", "--output", type=Path, default=DOCS / "tables" / "made_speakers.md")
    options = parser.parse_args()
    options.cache.mkdir(parents=True, exist_ok=True)
    corpus = Corpus(options.corpus)
    count = options.takes + options.held_out
    spread = np.linspace(0, len(corpus) - 1, SENTENCES).astype(int)
    order = np.random.default_rng(0).permutation(SENTENCES)[:count]  # fewer takes are some of the same
    names = [corpus.names[spread[place]] for place in order]
    takes = [spoken_part(corpus.take(name)) for name in names]
    people = {name: takes_of(takes, style, options.cache) for name, style in STYLES.items()}
    held = {name: found[options.takes :] for name, found in people.items()}
    start = started_from(corpus, takes, options.cache)
    performers = {}
    for name, found in people.items():
        known, settings = found[: options.takes], LearningSettings(speech_model="coarticulation")
        performers[name] = LearnedMouth(learn(known, settings, name="made", prior=start))
        print(f"learned: {name}, {len(known)} takes", flush=True)
    begun = LearnedMouth(start)
    lines = [
        "# Performers of made speakers",
        "",
        "Written by `python benchmarks/made_speakers.py CORPUS CACHE`; what was done stands at its head. "
        f"{count - len(held['plain'])} takes to learn from, {len(held['plain'])} held out, for each speaker.",
        "",
        "Lips of the face shown against the speaker's own held-out recordings: RMS from the front in mm, constant "
        "offset removed (r of the opening). A row is a speaker, a column a performer.",
        "",
        "| recordings of | "
        + " | ".join(performers)
        + " | start | nearest other / own | in space | others' own recordings |",
        "| --- |" + " ---: |" * (len(performers) + 4),
    ]
    for name, recordings in held.items():
        found = {other: distance(performer, recordings) for other, performer in performers.items()}
        nearest = [min(rms[k] for other, rms in found.items() if other != name) / found[name][k] for k in (0, 1)]
        cells = " | ".join(f"{rms:.2f} ({r:.2f})" for rms, _, r in (*found.values(), distance(begun, recordings)))
        apart = min(recorded_apart(recordings, those) for other, those in held.items() if other != name)
        lines.append(f"| {name} | {cells} | {nearest[0]:.2f} | {nearest[1]:.2f} | {apart:.2f} |")
    lines += [
        "",
        "Styles found again, of performers on the held-out lines beside the performer of the plain speaker:",
        "",
        "| speaker | jaw, true | found | rounding, true | found | late by, true ms | found |",
        "| --- | ---: | ---: | ---: | ---: | ---: | ---: |",
    ]
    for name, style in STYLES.items():
        if name == "plain":
            continue
        jaw, rounding, late = styled(performers[name], performers["plain"], held[name])
        true = f"{style.jaw:.2f} | {jaw:.2f} | {style.rounding:.2f} | {rounding:.2f} | {1000 * style.late:.0f}"
        lines.append(f"| {name} | {true} | {1000 * late:.0f} |")
    with replace_when_complete(options.output) as unfinished:
        unfinished.write_text("\n".join(lines) + "\n", encoding="utf-8")
    print("\n".join(lines))


if __name__ == "__main__":
    main()
