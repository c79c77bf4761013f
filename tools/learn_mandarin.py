"""Learn the performer `mandarin` from facegood-mandarin and put it where it ships (NOTICE).

    python tools/learn_mandarin.py DATA/facegood-mandarin CACHE
    python tools/learn_mandarin.py DATA/facegood-mandarin CACHE --without 1114_2_05 1114_3_16 -o test.mien

A professional speaker's rig curves become channels by a table (facegood_rig.toml); there are no transcripts, so phones
are those that mien's recogniser hears, which are the most alike English ones. A rounded one whose lips are not round
was misheard (Mandarin has vowels that English lacks) and counts as its unrounded neighbour. CACHE is a folder in which
phones are kept.
"""

from __future__ import annotations

import argparse
import json
import tomllib
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from tqdm import tqdm

from mien.capture.layouts import load_layout
from mien.core import channels
from mien.core.audio import Audio
from mien.core.timeline import FrameRate, Interval, Tier
from mien.core.tracks import ChannelTrack, MarkerTrack
from mien.core.utterance import PAUSE
from mien.corpus.take import Take
from mien.face.library import load_face
from mien.face.marker_sites import place_markers
from mien.face.retargeting import basis_at
from mien.formats.sound_files import read_audio
from mien.motion.learning import LearningSettings, learn
from mien.motion.performer_file import save_learned
from mien.speech.recognise import recognise

TARGET = Path(__file__).parent.parent / "src" / "mien" / "assets" / "performers" / "mandarin.mien"
RIG = Path(__file__).parent / "facegood_rig.toml"
LAYOUT, RATE = "mediapipe-218", FrameRate.of(30)
PAUSED, EDGE, SHORTEST, LONGEST = 0.6, 0.2, 0.25, 8.0
UNROUNDED, ROUND = {"UW": "IH", "UH": "AH", "OW": "AH", "W": "Y"}, 0.15
ABOUT = {
    "licence": "MIT",
    "citation": "FACEGOOD-Audio2Face, Copyright (c) 2022-2032 The FACEGOOD Authors; rig curves of one speaker",
}
Floats = NDArray[np.float64]


def as_channels(curves: Floats, names: list[str]) -> Floats:
    """Rig curves as weights of `mien.core.channels.WEIGHTS`, shape (frames, channels)."""
    table = tomllib.loads(RIG.read_text(encoding="utf-8"))
    values = np.zeros((len(curves), len(channels.WEIGHTS)))
    for curve, shares in table["curve"].items():
        for channel, share in shares.items():
            values[:, channels.WEIGHTS.index(channel)] += share * curves[:, names.index(curve)]
    shut = curves[:, [names.index(curve) for curve in table["shut"]["curves"]]].mean(axis=1)
    jaw = values[:, channels.WEIGHTS.index("jawOpen")]
    values[:, channels.WEIGHTS.index("mouthClose")] = jaw * np.minimum(1, table["shut"]["strength"] * shut)
    return np.clip(values, 0, 1)


def heard(folder: Path, cache: Path, name: str) -> list[Interval]:
    """The phones that the recogniser hears in a recording, kept in the cache."""
    kept = cache / f"{name}.phones.json"
    if not kept.exists():
        phones = recognise(read_audio(folder / "audio" / f"{name}.flac")[0]).phones
        kept.write_text(json.dumps([(p.start, p.end, p.label) for p in phones]), encoding="utf-8")
    return [Interval(*phone) for phone in json.loads(kept.read_text(encoding="utf-8"))]


def takes_of(folder: Path, cache: Path, name: str) -> Iterator[Take]:
    """A recording cut at its pauses."""
    file = np.load(folder / "curves.npz")
    values = as_channels(file[name].astype(np.float64), [str(n) for n in file["names"]])
    sound = read_audio(folder / "audio" / f"{name}.flac")[0]
    layout = load_layout(LAYOUT)
    placed = place_markers(load_face("default"), layout, layout.markers)
    basis = basis_at(load_face("default"), placed.sites, channels.WEIGHTS)
    for number, phones in enumerate(utterances(heard(folder, cache, name))):
        first = max(0, round((phones[0].start - EDGE) * RATE.fps))
        after = min(len(values), round((phones[-1].end + EDGE) * RATE.fps))
        start, end = first / RATE.fps, after / RATE.fps
        tier = [Interval(p.start - start, p.end - start, p.label) for p in phones]
        edges = [Interval(0.0, tier[0].start, PAUSE), *tier, Interval(tier[-1].end, end - start, PAUSE)]
        weights = values[first:after]
        places = placed.places + np.einsum("fc,cmd->fmd", weights, basis)
        samples = sound.samples[round(start * sound.rate) : round(end * sound.rate)]
        yield Take(
            f"{name}-{number:03d}",
            Audio(samples, sound.rate),
            MarkerTrack(layout.markers, places, RATE),
            "",
            Tier("words", ()),
            Tier("phones", tuple(p for p in edges if p.duration > 1e-6)),
            LAYOUT,
            speaker="facegood",
            channels=ChannelTrack(channels.WEIGHTS, weights, RATE),
        )


def heard_right(take: Take) -> Take:
    """A take whose rounded phones are those with round lips."""
    assert take.channels is not None
    pucker, phones = take.channels.channel("mouthPucker"), []
    for phone in take.phones:
        frames = slice(int(phone.start * RATE.fps), int(np.ceil(phone.end * RATE.fps)) + 1)
        misheard = phone.label in UNROUNDED and pucker[frames].max() < ROUND
        phones.append(Interval(phone.start, phone.end, UNROUNDED[phone.label]) if misheard else phone)
    return replace(take, phones=Tier("phones", tuple(phones)))


def utterances(phones: list[Interval]) -> Iterator[list[Interval]]:
    """Phones between longer pauses."""
    run: list[Interval] = []
    for phone in [*phones, Interval(phones[-1].end, phones[-1].end + 1.0, PAUSE)]:
        long = phone.label == PAUSE and (phone.duration >= PAUSED or (run and phone.end - run[0].start > LONGEST))
        if not long and (run or phone.label != PAUSE):
            run.append(phone)
        if long and run:
            while run[-1].label == PAUSE:
                run.pop()
            if run[-1].end - run[0].start >= SHORTEST:
                yield run
            run = []


def main() -> None:
    """Learn and save."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("cache", type=Path)
    parser.add_argument("--without", nargs="*", default=[], help="recordings to leave out")
    parser.add_argument("--speech-model", default="coarticulation")
    parser.add_argument("-o", "--output", type=Path, default=TARGET)
    options = parser.parse_args()
    names = sorted(p.stem for p in (options.folder / "audio").glob("*.flac") if p.stem not in options.without)
    takes = [heard_right(take) for name in names for take in takes_of(options.folder, options.cache, name)]
    with tqdm(desc="learning") as bar:

        def progress(done: int, total: int, what: str) -> None:
            bar.total = total
            bar.set_postfix_str(what)
            bar.update(done - bar.n)

        settings = LearningSettings(speech_model=options.speech_model)
        learned = learn(takes, settings, progress, name=options.output.stem, about=ABOUT)
    save_learned(learned, options.output)
    seconds = sum(take.duration for take in takes)
    size = options.output.stat().st_size / 1e6
    print(f"{options.output.name}: {len(takes)} takes, {seconds / 60:.1f} min, {size:.2f} MB")


if __name__ == "__main__":
    main()
