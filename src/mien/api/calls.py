"""The calls most people need: `say`, `animate`, `align`, `save`. The command line calls these and nothing else."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from mien.animation.animation import Animation, at_rate, imported
from mien.animation.edits import EditLayer
from mien.api import notebook  # noqa: F401 - animations show themselves from here on
from mien.core.audio import Audio
from mien.core.errors import InputError, Note
from mien.core.timeline import FrameRate
from mien.core.utterance import Utterance
from mien.formats.saving import save
from mien.motion.alive.visual_prosody import DEFAULT_STRENGTH
from mien.motion.performer import Performer
from mien.motion.performers import load_performer
from mien.pipeline.inputs import aligned, read_text, sound_of, spoken_recording, spoken_text, text_or_file
from mien.pipeline.options import (
    DEFAULT_FPS,
    Effort,
    Emotions,
    Rate,
    effort_by_hand,
    is_auto,
    layer_of,
    prepared,
    rate_of,
    score_of,
    score_with_voice,
    semitones_of,
    share_of,
    split_auto,
    with_heard_effort,
)
from mien.text.script import Script

__all__ = ["DEFAULT_FPS", "align", "animate", "express", "read_motion", "read_text", "save", "say"]


def say(
    text: str | Path | Script,
    *,
    emotion: Emotions = None,
    effort: Effort = None,
    voice: str | None = None,
    voice_emotion: float | str = 1.0,
    rate: float | str | None = None,
    pitch: float | str | None = None,
    language: str | Path | None = None,
    fps: Rate = DEFAULT_FPS,
    seed: int = 0,
    performer: Performer | str | Path = "default",
    speech_model: str | None = None,
    prosody: float | str = DEFAULT_STRENGTH,
    alive: str = "all",
    commands: str | Path | Sequence[str | Path] = (),
    edits: EditLayer | str | Path | None = None,
) -> Animation:
    """Speak a text with a synthetic voice and perform it.

    Parameters
    ----------
    text : str, Path or Script
        English, as written: numbers, dates and abbreviations are read out. Tags in it direct the face and the voice
        (``docs/script.md``): ``"That is <HeadNod/> true."``; it may also be a document (mien's own XML, SSML, BML). A
        Path names a file: ``.txt``, ``.xml``, ``.ssml`` or ``.bml``.
    emotion : str, EmotionSpan, sequence of these, or None
        ``"happy"``, ``"happy:0.6"``, ``"happy:0.2@0,0.9@1.5"`` (value at second), ``"angry[0.5-1.2]:0.8"`` (from second
        to second), ``"sad:curve.csv"``; several blend into one another. ``"parameters.csv"`` alone is a file of MPEG-4
        expression parameters (`mien.text.expression_parameters`).
    effort : float, str, EffortCurve, EffortSpan or None
        How hard the words are articulated, 0 to 2 (1: as recorded): ``1.4``, ``"0.5@0,1.6@2"`` (value at second),
        ``"curve.csv"`` (``docs/effort.md``). None: 1, and what the emotions have of their own; ``"off"``: 1.
    voice : str or None
        Name of a voice (``mien voices`` lists them), the part of it that no other has (``"heart"``), ``"female"`` or
        ``"male"``; None takes the best one that is installed.
    voice_emotion : float or "off"
        How much the voice goes with the emotion: 0 (or ``"off"``: it speaks as without one) to 1.
    rate : float, str or None
        How fast it is spoken: 1 as usual, ``0.8`` or ``"80%"`` slower. As ``<prosody>`` around the whole: an emotion
        then leaves it alone.
    pitch : float, str or None
        Semitones above the usual.
    language : str, Path or None
        A tag such as ``"fi"``, or a phone map in a file (``docs/languages.md``); None takes the voice's, and English
        without one.
    fps : float, str or FrameRate
        Frames per second of the animation.
    seed : int
        Same text, options, seed and version: same animation, bit for bit.
    performer : Performer, str or Path
        A performer, its name (``"default"``, ``"hand-made"``), or a ``.mien`` file.
    speech_model : str or None
        What moves the mouth: ``"coarticulation"`` (learned curves), ``"graph"`` (recorded motion) or ``"both"``, as
        far as the performer has learned it; None takes the performer's own.
    prosody : float or "off"
        How much brows and head go with the accents and phrase ends of the voice: 0 (or ``"off"``) to 1.
    alive : str
        Which signs of life besides: ``"blinks"``, ``"gaze"``, ``"head"`` (with the voice, learned), ``"sway"`` (a slow
        drift of it), with commas between; ``"all"`` or ``"off"``.
    commands : path-like or sequence of path-like
        Folders with command files of your own (``docs/commands.md``).
    edits : EditLayer, path-like or None
        Edits by hand, or a file of them (``docs/edits.md``); ``edits.lost`` of the result lists what of them has no
        place in this line.

    Raises
    ------
    InputError
        If the text is empty or cannot be spoken, or an option is not understood.
    MissingPartError
        If no voice is installed.

    Examples
    --------
    >>> import mien
    >>> line = mien.say("I never said that.", emotion="angry:0.7")  # doctest: +SKIP
    >>> mien.save(line, "line.mp4", "line.glb")  # doctest: +SKIP
    """
    from mien.pipeline.edited_performance import perform_spoken

    if split_auto(emotion)[1]:
        raise InputError(
            "'auto' reads the emotion from a recorded voice; a synthetic one has what it is given: name an emotion"
        )
    layer = layer_of(edits)
    performer, score, frames = prepared(
        performer, emotion, fps, seed, prosody, speech_model, alive, effort_by_hand(effort)
    )
    spoken = spoken_text(
        text,
        performer,
        voice=voice,
        language=language,
        seed=seed,
        commands=commands,
        score=score,
        voice_emotion=share_of("emotion in the voice", voice_emotion),
        rate=rate_of(rate),
        pitch=semitones_of(pitch),
    )
    return perform_spoken(spoken, performer, frames, seed, score, layer)


def animate(
    audio: str | Path | Audio,
    *,
    text: str | Path | Script | None = None,
    language: str | Path | None = None,
    song: bool = False,
    tiers: Sequence[str] = (),
    emotion: Emotions = None,
    effort: Effort = None,
    fps: Rate = DEFAULT_FPS,
    seed: int = 0,
    performer: Performer | str | Path = "default",
    speech_model: str | None = None,
    prosody: float | str = DEFAULT_STRENGTH,
    alive: str = "all",
    commands: str | Path | Sequence[str | Path] = (),
    edits: EditLayer | str | Path | None = None,
) -> Animation:
    """Perform recorded speech.

    Parameters
    ----------
    audio : str, Path or Audio
        A sound file, a video with a sound track, or samples.
    text : str, Path, Script or None
        What is said, or a file that holds it; with tags as for `say`. Without it phones are recognised, which is
        approximate. A ``.TextGrid`` gives words and phones with their times, which are kept as they are.
    language : str, Path or None
        What is spoken: a tag such as ``"fi"``, or a phone map in a file; None: English.
    song : bool
        Whether it is a song and the text its lyrics: aligned with held notes and a band behind the voice, and sung by
        the face (``docs/song.md``).
    tiers : sequence of str
        Names of the tiers of words and of phones in a TextGrid, where they are not called ``words`` and ``phones``.
    emotion
        As for `say`; ``"auto"`` (alone or among others) reads emotions and their intensities from the voice
        (``docs/emotion.md``), neutral where it is not sure.
    effort
        As for `say`; None and ``"auto"`` read it from the voice's level, spectrum and pitch. Where an emotion is shown,
        its own effort takes the place of what was read; with ``"auto"`` it does not.
    fps, seed, performer, speech_model, prosody, alive, commands, edits
        As for `say`.

    Raises
    ------
    InputError
        If the sound cannot be read or an option is not understood.
    """
    from mien.pipeline.edited_performance import perform_spoken

    emotion, from_voice = split_auto(emotion)
    layer = layer_of(edits)
    performer, score, rate = prepared(performer, emotion, fps, seed, prosody, speech_model, alive, effort)
    notes: tuple[Note, ...] = ()
    if from_voice:
        audio, read = sound_of(audio)
        score, note = score_with_voice(score, audio)
        performer.expression.check(score)
        notes = (*read, note)
    if isinstance(text, str):
        text = text_or_file(text)
    spoken = spoken_recording(
        audio, performer, text=text, language=language, song=song, tiers=tiers, commands=commands, notes=notes
    )
    score, spoken = with_heard_effort(score, spoken, is_auto(effort))
    return perform_spoken(spoken, performer, rate, seed, score, layer)


def express(
    motion: str | Path | Animation,
    *,
    emotion: Emotions = None,
    fps: Rate | None = None,
    seed: int = 0,
    performer: Performer | str | Path = "default",
) -> Animation:
    """Lay an expression over motion that exists already; without an emotion it is read as it is.

    Parameters
    ----------
    motion : str, Path or Animation
        An animation, its native ``.json`` file, or a Live Link Face ``.csv``.
    emotion : str, EmotionSpan or sequence of these
        As for `say`.
    fps : float, str, FrameRate or None
        Frame rate to which a native animation is brought; for a ``.csv`` the rate that it has, which None reads from
        its timecode.
    seed, performer
        As for `say`.

    Raises
    ------
    InputError
        If the motion cannot be read, or an option is not understood.
    """
    score = score_of(emotion)
    if not score.emotions:
        return read_motion(motion, fps)
    if not isinstance(performer, Performer):
        performer = load_performer(performer)
    performer.expression.check(score)
    from mien.pipeline.perform import express as lay_over

    return lay_over(read_motion(motion, fps), score, performer, seed)


def read_motion(motion: str | Path | Animation, fps: Rate | None = None) -> Animation:
    """An animation as it is, or read from a native ``.json`` or a Live Link Face ``.csv``.

    ``fps`` brings a native animation to another frame rate; for a ``.csv`` it says what its rate is.

    Raises
    ------
    InputError
        If the motion cannot be read.
    """
    if isinstance(motion, Animation):
        return motion
    suffix = Path(motion).suffix.lower()
    if suffix == ".json":
        from mien.formats.native import read_native

        read = read_native(motion)
        return read if fps is None else at_rate(read, FrameRate.of(fps))
    if suffix == ".csv":
        from mien.formats.livelink import first_timecode, read_livelink

        track, notes = read_livelink(motion, FrameRate.of(fps) if fps is not None else None)
        return imported(track, Path(motion).stem, notes, first_timecode(motion))
    raise InputError(f"expected a native animation (.json) or a Live Link Face recording (.csv), got {motion}")


def align(
    audio: str | Path | Audio,
    text: str | Path,
    *,
    language: str | Path | None = None,
    song: bool = False,
    tiers: Sequence[str] = (),
) -> Utterance:
    """Find when each word and phone of a text is said in a sound (forced alignment).

    ``language`` is a tag such as ``"fi"`` or a phone map in a file (``docs/languages.md``); None: English.
    ``song``: the sound is a song and the text its lyrics (``docs/song.md``). A text that is a ``.TextGrid`` gives words
    and phones with their times (``tiers`` names its tiers): phones of words alone are aligned inside them.

    Raises
    ------
    InputError
        If sound or text cannot be read, or cannot be brought together.
    """
    return aligned(audio, text_or_file(text), language, song, tiers)
