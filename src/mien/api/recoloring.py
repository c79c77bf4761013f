"""`recolor`: motion as it would be in another emotion, its words and its edits kept.

Two ways lead there:

* *learned*: the performer's map between emotions (`mien.motion.maps.emotion_maps`), from recordings of the same
  sentences in both. It moves markers: those of a recorded take or a marker file as they are, those of an animation
  where they sit on the face; the change goes back to the face's channels.
* *hand-made*: what the performer's expression does in the old emotion is taken out, what it does in the new one is put
  in, so that edits made since stay. Expressions that were not recorded are hand-made, and the result says so.
"""

from __future__ import annotations

from dataclasses import replace
from importlib.metadata import version
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from mien.animation.animation import Animation, Provenance
from mien.capture.cleaning.normalise import best_similarity
from mien.capture.layouts import load_layout
from mien.core import channels
from mien.core.audio import Audio
from mien.core.errors import InputError, Note
from mien.core.opposed_channels import apart
from mien.core.timeline import FrameRate, Interval, Tier
from mien.core.tracks import ChannelTrack, MarkerTrack
from mien.core.utterance import PAUSE, Utterance
from mien.corpus.take import Take
from mien.motion.expression.expression import NEUTRAL, Expression, weights_of
from mien.motion.maps.emotion_maps import EmotionMaps
from mien.motion.marker_channels import MarkerChannels
from mien.motion.mouth.hand_made_mouth import HandMadeMouth
from mien.motion.performer import Performer
from mien.motion.performers import FORMER_NAME, load_performer
from mien.pipeline.edited_performance import recoloured_under_edits
from mien.pipeline.perform import express, perform
from mien.text.score import EmotionSpan, Score

__all__ = ["Way", "recolor", "recolor_markers", "recolor_take", "shown_markers"]

Floats = NDArray[np.float64]
Way = Literal["auto", "learned", "hand-made"]
"""``auto``: learned where the performer has a map, else hand-made."""
WAYS: tuple[Way, ...] = ("auto", "learned", "hand-made")
_BLINK = [channels.ALL.index(f"eyeBlink{side}") for side in ("Left", "Right")]


def recolor(
    animation: Animation,
    emotion: str | EmotionSpan,
    performer: Performer | str | Path | None = None,
    way: Way = "auto",
) -> Animation:
    """The same speech in another emotion.

    Parameters
    ----------
    animation : Animation
        As `mien.animate` or `mien.say` made it, edited or not; one made elsewhere counts as neutral if its score is
        empty.
    emotion : str or EmotionSpan
        Takes the place of all emotions of the score; ``"neutral"`` takes them out.
    performer : Performer, str or Path, optional
        Whose expressions or map; the one that made the animation unless given.
    way : {"auto", "learned", "hand-made"}
        See above.

    Returns
    -------
    Animation
        Its markers, which are of the mouth alone, stay as they are; a layer of edits is laid on again.

    Raises
    ------
    InputError
        If the performer cannot be found, does not have the emotion, or has no map where one is asked for.
    """
    _check_way(way)
    span = EmotionSpan.parse(emotion) if isinstance(emotion, str) else emotion
    if animation.edits is not None:  # what was edited by hand is laid on again, over the other emotion
        return recoloured_under_edits(animation, span, lambda bare, drawn: recolor(bare, drawn, performer, way))
    actor = _performer(animation, performer)
    maps = _maps(actor, (NEUTRAL, span.name), way) if span.name != NEUTRAL else None
    if maps is None:
        return _hand_made_way(animation, span, actor)
    plain = animation
    if animation.score.emotions:  # what it shows is taken out as its own performer put it in
        plain = _hand_made_way(animation, EmotionSpan(NEUTRAL), _maker(animation, actor))
    felt = _learned_way(plain, span, maps)
    return replace(felt, score=replace(animation.score, emotions=(span,)))


def recolor_take(
    take: Take,
    emotion: str | EmotionSpan,
    performer: Performer | str | Path = "default",
    way: Way = "auto",
    seed: int = 0,
) -> Animation:
    """A recorded take in another emotion: its markers, and the face that moves as they do.

    Where no map leads from the take's emotion to the other, the hand-made expression is laid over the recorded motion,
    and the markers move as the face does under them.

    Raises
    ------
    InputError
        If a marker was lost, the emotion is not known, or there is no map where one is asked for.
    """
    _check_way(way)
    span = EmotionSpan.parse(emotion) if isinstance(emotion, str) else emotion
    actor = performer if isinstance(performer, Performer) else load_performer(performer)
    spoken = Utterance(take.text, take.audio, take.words, take.phones, "en-US", "aligned")
    source = take.emotion or NEUTRAL
    maps = _maps(actor, (source, span.name), way)
    name = f"take {take.name}"
    if maps is None:
        plain = _on_face(take.markers, take.layout, _resting(take), spoken, name, seed)
        if source != NEUTRAL:
            told = f"{name} was recorded {source}: its emotion stays in it, as no map from it was learned"
            plain = replace(plain, notes=(*plain.notes, Note("warning", told)))
        felt, face = (
            _laid_over(plain, span, actor, seed),
            MarkerChannels(take.layout, take.markers.names, _resting(take)),
        )
        moved = face.positions_of(felt.channels.values) - face.positions_of(plain.channels.values)
        change = _covering(moved, len(take.markers) / take.markers.rate.fps, take.markers.rate)[: len(take.markers)]
        positions = take.markers.positions + change
        return replace(felt, markers=MarkerTrack(take.markers.names, positions, take.markers.rate))
    _check_markers(take.markers, maps, name)
    changed = _mapped(take.markers, span, source, maps, seed)
    result = _on_face(changed, maps.layout, maps.rest, spoken, name, seed)
    return replace(result, score=Score((span,)), notes=(*result.notes, _told(maps, source, span.name)))


def recolor_markers(
    track: MarkerTrack,
    emotion: str | EmotionSpan,
    performer: Performer | str | Path,
    source: str = NEUTRAL,
    seed: int = 0,
) -> MarkerTrack:
    """Bare markers of any recording in another emotion, by a learned map.

    The head may move: each frame is laid on the performer's resting markers by those that sit on the skull, and the
    change is turned and sized back into the recording.

    Parameters
    ----------
    track : MarkerTrack
        With the markers that the map was learned from; any more are left as they are.
    emotion : str or EmotionSpan
    performer : Performer, str or Path
    source : str
        The emotion of the recording.
    seed : int

    Raises
    ------
    InputError
        If the performer has no map, or a marker of it is missing.
    """
    span = EmotionSpan.parse(emotion) if isinstance(emotion, str) else emotion
    actor = performer if isinstance(performer, Performer) else load_performer(performer)
    maps = _maps(actor, (source, span.name), "learned")
    assert maps is not None
    _check_markers(track, maps, "the recording")
    kept = [track.names.index(name) for name in maps.markers]
    normal, turns = _laid_on_rest(track.positions[:, kept], maps)
    changed = _mapped(MarkerTrack(maps.markers, normal, track.rate), span, source, maps, seed).positions
    result = track.positions.copy()
    result[:, kept] += np.einsum("tij,tmj->tmi", np.linalg.inv(turns), changed - normal)
    return MarkerTrack(track.names, result, track.rate)


def shown_markers(
    track: MarkerTrack,
    emotion: str | EmotionSpan,
    performer: Performer,
    audio: Audio | None = None,
    name: str = "markers",
    seed: int = 0,
) -> Animation:
    """Markers of `recolor_markers` as an animation: the face that moves so, over their sound or silence."""
    maps = performer.emotion_maps
    if maps is None:
        raise InputError(f"performer {performer.name!r} has no maps between emotions, so its markers are not known")
    _check_markers(track, maps, name)
    normal, _ = _laid_on_rest(track.positions[:, [track.names.index(one) for one in maps.markers]], maps)
    seconds = len(track) / track.rate.fps
    pause = Tier("phones", (Interval(0.0, audio.duration if audio else seconds, PAUSE),))
    sound = audio or Audio.silence(seconds, 16_000)
    silent = Utterance("", sound, Tier("words", ()), pause, "und", "none")
    shown = _on_face(MarkerTrack(maps.markers, normal, track.rate), maps.layout, maps.rest, silent, name, seed)
    span = EmotionSpan.parse(emotion) if isinstance(emotion, str) else emotion
    return replace(shown, markers=track, score=Score((span,)))


# ---- The learned way -----------------------------------------------------------------------------------------------


def _check_way(way: str) -> None:
    if way not in (*WAYS, FORMER_NAME):
        raise InputError(f"a way to another emotion is {', '.join(WAYS)}, not {way!r}")


def _maps(actor: Performer, step: tuple[str, str], way: Way) -> EmotionMaps | None:
    """The performer's maps, if one leads from an emotion to the other and is not unwanted."""
    if way in ("hand-made", FORMER_NAME):
        return None
    maps = actor.emotion_maps
    if maps is not None and maps.way(*step) is not None:
        return maps
    if way == "learned":
        has = "none" if maps is None else ", ".join(f"{a} to {b}" for a, b in sorted(maps.maps))
        raise InputError(
            f"performer {actor.name!r} has no map from {step[0]!r} to {step[1]!r} (it has: {has}); one is learned by "
            "'mien learn' from a corpus with the same sentences in both emotions"
        )
    return None


def _check_markers(track: MarkerTrack, maps: EmotionMaps, what: str) -> None:
    lacking = [name for name in maps.markers if name not in track.names]
    if lacking:
        raise InputError(
            f"{what} lacks {len(lacking)} of the {len(maps.markers)} markers that the map moves, such as "
            f"{', '.join(lacking[:3])}"
        )
    kept = track.positions[:, [track.names.index(name) for name in maps.markers]]
    lost = np.argwhere(~np.isfinite(kept).all(axis=2))
    if len(lost):
        frame, marker = lost[0]
        raise InputError(f"{what}: marker {maps.markers[marker]} was lost in frame {frame}; fill gaps first")


def _laid_on_rest(positions: Floats, maps: EmotionMaps) -> tuple[Floats, Floats]:
    """Frames laid on the resting markers by those on the skull, and each frame's turn and scale, (frames, 3, 3)."""
    layout = load_layout(maps.layout)
    skull = np.array([name in layout.rigid for name in maps.markers], dtype=np.float64)
    if skull.sum() < 3:
        skull = np.ones(len(maps.markers))
    laid = np.stack([best_similarity(frame, maps.rest, skull, scale=True) for frame in positions])
    turns, moves = laid[:, :3, :3], laid[:, :3, 3]
    return np.einsum("tij,tmj->tmi", turns, positions) + moves[:, None], turns


def _told(maps: EmotionMaps, source: str, target: str) -> Note:
    way = " and ".join(f"{a} to {b} ({maps.sentences[a, b]} sentences)" for a, b in maps.way(source, target) or ())
    return Note("note", f"changed by a map that was learned from recordings: {way or 'nothing to change'}")


def _mapped(track: MarkerTrack, span: EmotionSpan, source: str, maps: EmotionMaps, seed: int) -> MarkerTrack:
    """Markers of the map in the other emotion, as strong as the span asks at each instant."""
    positions = track.positions[:, [track.names.index(name) for name in maps.markers]]
    random = np.random.default_rng(seed)
    change = maps.apply(positions, source, span.name, track.rate, random) - positions
    strength = weights_of(Score((span,)), track.rate.times(len(track)))[1]
    return MarkerTrack(maps.markers, positions + strength[:, None, None] * change, track.rate)


def _learned_way(animation: Animation, span: EmotionSpan, maps: EmotionMaps) -> Animation:
    """A neutral animation changed as the performer's recorded markers change."""
    values = animation.channels.select(channels.ALL).values
    face = MarkerChannels(maps.layout, maps.markers, maps.rest)
    rate, still = animation.rate, values.copy()
    still[:, _BLINK] = 0.0  # lids that blink are no emotion
    before = MarkerTrack(maps.markers, face.positions_of(still), rate)
    after = _mapped(before, span, NEUTRAL, maps, animation.provenance.seed)
    change = face.channels_of(after.positions - face.rest, rate)
    change -= face.channels_of(before.positions - face.rest, rate)
    seal = np.zeros(len(values))
    sealed = HandMadeMouth().seals(animation.utterance, rate)[0][: len(values)]
    seal[: len(sealed)] = sealed
    made = values + change * (1 - seal[:, None] * (1 - Performer.hand_made().expression.sealed_share))
    made[:, _BLINK] = np.maximum(made[:, _BLINK], values[:, _BLINK])
    return replace(
        animation,
        channels=ChannelTrack(channels.ALL, _clipped(made), rate),
        notes=(*animation.notes, _told(maps, NEUTRAL, span.name)),
    )


def _clipped(values: Floats) -> Floats:
    weights = slice(0, len(channels.WEIGHTS))
    values[:, weights] = np.clip(values[:, weights], 0.0, 1.0)
    return apart(values, channels.ALL)


def _resting(take: Take) -> Floats:
    """A take's markers in its pauses, or in all frames if it has none."""
    times = take.markers.rate.times(len(take.markers))
    quiet = [any(p.start <= time < p.end for p in take.phones if p.label == PAUSE) for time in times]
    rows = take.markers.positions[np.array(quiet) if any(quiet) else slice(None)]
    return np.asarray(np.nanmean(rows, axis=0))


def _on_face(markers: MarkerTrack, layout: str, rest: Floats, spoken: Utterance, name: str, seed: int) -> Animation:
    """Markers as an animation: the channels that move the face so; eyes and head look ahead."""
    face = MarkerChannels(layout, markers.names, rest)
    values = face.channels_of(markers.positions - rest, markers.rate)
    track = ChannelTrack(channels.ALL, _covering(values, spoken.duration, markers.rate), markers.rate)
    made = Provenance(f"recorded: {name}", seed, version("mien"))
    return Animation(track, markers, spoken, Score(), made)


def _covering(values: Floats, seconds: float, rate: FrameRate) -> Floats:
    """As many frames as the sound takes: cut, or the last one held."""
    wanted = rate.frames_covering(seconds)
    held = np.repeat(values[-1:], max(wanted - len(values), 0), axis=0)
    return np.concatenate([values, held])[:wanted]


# ---- The hand-made way ----------------------------------------------------------------------------------------------


def _hand_made_way(animation: Animation, span: EmotionSpan, actor: Performer) -> Animation:
    score = replace(animation.score, emotions=(span,))
    actor.expression.check(score)
    # A performance made elsewhere may hold emotions that this performer does not have: they cannot be taken out.
    actor.expression.check(animation.score)
    rate, seed = animation.rate, animation.provenance.seed
    before = perform(animation.utterance, animation.score, actor, rate, seed).channels.values
    after = perform(animation.utterance, score, actor, rate, seed)
    count = len(animation.channels)
    if count != len(before):
        raise InputError(f"expected {len(before)} frames over the sound, got {count}: is the animation cut?")
    own = animation.channels.select(channels.ALL).values
    values = _clipped(own + (after.channels.values - before))
    # What this performer did not make differs everywhere, edited or not.
    made_here = animation.provenance.performer == actor.name
    edited = int((np.abs(own - before) > 1e-6).any(axis=1).sum()) if made_here else 0
    told = f"{edited} of {count} frames had been edited: the edits are kept on top" if edited else ""
    notes = [n for n in (*animation.notes, *after.notes) if n not in after.utterance.notes]
    return replace(
        animation,
        channels=ChannelTrack(channels.ALL, values, rate),
        score=score,
        provenance=after.provenance,
        notes=(*dict.fromkeys(notes), *_hand_made(actor, span), *([Note("note", told)] if told else [])),
    )


def _laid_over(animation: Animation, span: EmotionSpan, actor: Performer, seed: int) -> Animation:
    """The hand-made expression over recorded motion, which holds no expression of the performer's to take out."""
    if span.name == NEUTRAL:
        return animation
    felt = express(animation, Score((span,)), actor, seed)
    return replace(felt, notes=(*felt.notes, *_hand_made(actor, span)))


def _hand_made(actor: Performer, span: EmotionSpan) -> tuple[Note, ...]:
    if not isinstance(actor.expression, Expression) or span.name not in actor.expression.hand_made - {NEUTRAL}:
        return ()
    return (Note("note", f"the expression {span.name!r} is hand-made, not learned from recordings"),)


def _maker(animation: Animation, actor: Performer) -> Performer:
    """Who made an animation; another, where that one is not at hand."""
    try:
        return _performer(animation, None) if animation.provenance.performer != actor.name else actor
    except InputError:
        return actor


def _performer(animation: Animation, performer: Performer | str | Path | None) -> Performer:
    if isinstance(performer, Performer):
        return performer
    asked = performer if performer is not None else animation.provenance.performer
    try:
        return load_performer(asked)
    except InputError as problem:
        if performer is not None:
            raise
        raise InputError(
            f"the animation was made by the performer {asked!r}, which is not available: name one with --performer"
        ) from problem
