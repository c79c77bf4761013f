"""The calls most people need: `say`, `animate`, `align`, `save`. The command line calls these and nothing else."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING

from mien.animation import Animation, imported
from mien.audio import Audio
from mien.audio_files import read_audio
from mien.edits import EMPTY, EditLayer, read_layer
from mien.errors import InputError, Note
from mien.face.face import Face
from mien.models.authored_idle import AuthoredIdle
from mien.models.authored_prosody import DEFAULT_STRENGTH, AuthoredProsody
from mien.models.performer import Performer
from mien.models.performers import load_performer
from mien.script.commands import CommandLibrary
from mien.script.document import Script
from mien.script.expression_parameters import read_expression_parameters
from mien.script.score import EmotionSpan, Score
from mien.speech.utterance import Utterance
from mien.timeline import FrameRate

if TYPE_CHECKING:
    from mien.face.foreign.recognition import ForeignFace
    from mien.modules.spoken import Spoken

__all__ = ["DEFAULT_FPS", "align", "animate", "express", "read_text", "save", "say"]

DEFAULT_FPS = 30
_DOCUMENTS = (".xml", ".ssml", ".bml")

Progress = Callable[[int, int], None]
Rate = float | str | Fraction | FrameRate
Emotions = str | EmotionSpan | Sequence[str | EmotionSpan] | None


def say(
    text: str | Path | Script,
    *,
    emotion: Emotions = None,
    voice: str | None = None,
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
        expression parameters (`mien.script.expression_parameters`).
    voice : str or None
        Name of a voice (``mien doctor`` lists them); None takes the best one that is installed.
    language : str, Path or None
        A tag such as ``"fi"``, or a phone map in a file (``docs/languages.md``); None takes the voice's, and English
        without one.
    fps : float, str or FrameRate
        Frames per second of the animation.
    seed : int
        Same text, options, seed and version: same animation, bit for bit.
    performer : Performer, str or Path
        A performer, its name (``"default"``, ``"authored"``), or a ``.mien`` file.
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
    from mien.modules.perform import perform_spoken

    if _split_auto(emotion)[1]:
        raise InputError("'auto' reads the emotion from a recorded voice; a synthetic one has none: name an emotion")
    layer = _layer(edits)
    performer, score, rate = _prepared(performer, speech_model, emotion, fps, seed, prosody, alive)
    spoken = spoken_text(text, performer, voice=voice, language=language, seed=seed, commands=commands)
    return perform_spoken(spoken, performer, rate, seed, score, layer)


def animate(
    audio: str | Path | Audio,
    *,
    text: str | Path | Script | None = None,
    language: str | Path | None = None,
    song: bool = False,
    emotion: Emotions = None,
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
        approximate.
    language : str, Path or None
        What is spoken: a tag such as ``"fi"``, or a phone map in a file; None: English.
    song : bool
        Whether it is a song and the text its lyrics: aligned with held notes and a band behind the voice, and sung by
        the face (``docs/song.md``).
    emotion
        As for `say`; ``"auto"`` (alone or among others) reads emotions and their intensities from the voice
        (``docs/emotion.md``), neutral where it is not sure.
    fps, seed, performer, speech_model, prosody, alive, commands, edits
        As for `say`.

    Raises
    ------
    InputError
        If the sound cannot be read or an option is not understood.
    """
    from mien.modules.perform import perform_spoken

    emotion, from_voice = _split_auto(emotion)
    layer = _layer(edits)
    performer, score, rate = _prepared(performer, speech_model, emotion, fps, seed, prosody, alive)
    heard: tuple[Note, ...] = ()
    if from_voice:
        audio, read = _sound(audio)
        score, note = score_with_voice(score, audio)
        performer.expression.check(score)
        heard = (*read, note)
    spoken = spoken_recording(audio, performer, text=text, language=language, song=song, commands=commands, notes=heard)
    return perform_spoken(spoken, performer, rate, seed, score, layer)


def spoken_text(
    text: str | Path | Script,
    performer: Performer,
    *,
    voice: str | None = None,
    language: str | Path | None = None,
    seed: int = 0,
    commands: str | Path | Sequence[str | Path] = (),
) -> Spoken:
    """The first half of `say`: a text with a voice and all its direction in time, before anybody performs it.

    Parameters
    ----------
    performer : Performer
        Must have the emotions that the text asks for.
    text, voice, language, seed, commands
        As for `say`.

    Raises
    ------
    InputError, MissingPartError
        As `say`.
    """
    from mien.modules.speak import speak
    from mien.modules.translate import translate

    library = _library(commands)
    script = _script(text, library)
    performer.expression.check(Score(tuple(EmotionSpan(asked.name) for asked in script.emotions)))
    return translate(speak(script, voice, seed, library, language), library)


def spoken_recording(
    audio: str | Path | Audio,
    performer: Performer,
    *,
    text: str | Path | Script | None = None,
    language: str | Path | None = None,
    song: bool = False,
    commands: str | Path | Sequence[str | Path] = (),
    notes: tuple[Note, ...] = (),
) -> Spoken:
    """The first half of `animate`: a recording with its words, phones and direction in time.

    Parameters
    ----------
    performer : Performer
        Must have the emotions that the text asks for.
    audio, text, language, song, commands
        As for `animate`.
    notes : tuple of Note
        What is known of the sound already.

    Raises
    ------
    InputError
        As `animate`.
    """
    from mien.modules.speak import speak_over
    from mien.modules.spoken import Spoken
    from mien.modules.translate import translate

    library = _library(commands)
    if text is None:
        return Spoken(_heard(audio, None, language, song).with_notes(*notes))
    script = _script(text if isinstance(text, Script) else _file_or_text(text), library)
    performer.expression.check(Score(tuple(EmotionSpan(asked.name) for asked in script.emotions)))
    spoken = speak_over(
        script, lambda words, said: _heard(audio, words, said, song).with_notes(*notes), library, language
    )
    return translate(spoken, library)


def express(
    motion: str | Path | Animation,
    *,
    emotion: Emotions,
    fps: Rate | None = None,
    seed: int = 0,
    performer: Performer | str | Path = "default",
) -> Animation:
    """Lay an expression over motion that exists already.

    Parameters
    ----------
    motion : str, Path or Animation
        An animation, its native ``.json`` file, or a Live Link Face ``.csv``.
    emotion : str, EmotionSpan or sequence of these
        As for `say`.
    fps : float, str, FrameRate or None
        Of a ``.csv``; None reads it from the timecode.
    seed, performer
        As for `say`.

    Raises
    ------
    InputError
        If the motion cannot be read, or an option is not understood.
    """
    score = _score(emotion)
    if not score.emotions:
        raise InputError("expected an emotion to lay over the motion, such as happy:0.6")
    if not isinstance(performer, Performer):
        performer = load_performer(performer)
    performer.expression.check(score)
    from mien.pipeline import express as lay_over

    return lay_over(_moved(motion, fps), score, performer, seed)


def _moved(motion: str | Path | Animation, fps: Rate | None) -> Animation:
    if isinstance(motion, Animation):
        return motion
    suffix = Path(motion).suffix.lower()
    if suffix == ".json":
        if fps is not None:
            raise InputError("fps is for a .csv: a native animation knows its own")
        from mien.output.native import read_native

        return read_native(motion)
    if suffix == ".csv":
        from mien.livelink import read_livelink

        return imported(read_livelink(motion, FrameRate.of(fps) if fps is not None else None), Path(motion).stem)
    raise InputError(f"expected a native animation (.json) or a Live Link Face recording (.csv), got {motion}")


def align(
    audio: str | Path | Audio, text: str | Path, *, language: str | Path | None = None, song: bool = False
) -> Utterance:
    """Find when each word and phone of a text is said in a sound (forced alignment).

    ``language`` is a tag such as ``"fi"`` or a phone map in a file (``docs/languages.md``); None: English.
    ``song``: the sound is a song and the text its lyrics (``docs/song.md``).

    Raises
    ------
    InputError
        If sound or text cannot be read, or cannot be brought together.
    """
    return _heard(audio, text, language, song)


def save(
    animation: Animation,
    *paths: str | Path,
    face: str | Path | Face | ForeignFace = "default",
    names: str | Path | None = None,
    progress: Progress | None = None,
) -> tuple[Note, ...]:
    """Write an animation; the suffix of each path picks its format (``docs/formats.md``).

    Parameters
    ----------
    animation : Animation
    *paths : str or Path
        ``.mp4 .glb .csv .TextGrid .json .png .wav``; all are checked before the first is written.
    face : str, Path, Face or ForeignFace
        The face for the formats that show one: by name, loaded, or one of another maker (``.glb``, ``.vrm``,
        ``.gltf``), which is driven by its own morph targets and written with everything else in it.
    names : str, Path or None
        A table of names of your own for such a face (``docs/faces.md``).
    progress : callable (done, total) or None
        Called while frames are drawn.

    Returns
    -------
    tuple of Note
        What a format could not hold beyond what it always loses.

    Raises
    ------
    InputError
        If a suffix or the face is not known.
    OutputError
        If a file cannot be written; nothing is left half-written.
    """
    from mien.face.foreign.document import is_gltf
    from mien.face.foreign.recognition import ForeignFace, foreign_face
    from mien.face.library import load_face
    from mien.output.registry import check_output
    from mien.output.registry import save as save_one

    targets = [check_output(path) for path in paths]
    if isinstance(face, (str, Path)) and is_gltf(face):
        face = foreign_face(face, names)
    if isinstance(face, ForeignFace):
        return tuple(note for target in targets for note in _save_foreign(animation, target, face, progress))
    if names is not None:
        raise InputError("names are for a face in .glb, .vrm or .gltf")
    if isinstance(face, Path):
        face = str(face)
    shown = load_face(face) if isinstance(face, str) else face
    return tuple(note for target in targets for note in save_one(animation, target, face=shown, progress=progress))


def _save_foreign(animation: Animation, target: Path, face: ForeignFace, progress: Progress | None) -> tuple[Note, ...]:
    """Write one file where the face is somebody else's."""
    from mien.face.foreign.drawn import drawn_face
    from mien.output.driven_glb import drive_glb
    from mien.output.registry import save as save_one

    if target.suffix.lower() == ".glb":
        return drive_glb(animation.channels, face, target)
    if target.suffix.lower() in (".mp4", ".png"):
        drawn = drawn_face(face)
        shown = replace(animation, channels=drawn.track(animation.channels))
        notes = save_one(shown, target, face=drawn.face, progress=progress)
        return (*(Note("warning", fault) for fault in drawn.notes), *notes)
    if target.suffix.lower() in (".usda", ".usdc", ".usdz", ".c3d"):
        drawn = drawn_face(face)
        told = "sums of channels are held in 0..1 by mien only: the file has one target for each channel"
        return (Note("note", told), *save_one(animation, target, face=drawn.by_channels(), progress=progress))
    if target.suffix.lower() == ".fap":
        told = f"{target}: face animation parameters are measured on the default face, not on {face.document.path.name}"
        return (Note("note", told), *save_one(animation, target))
    return save_one(animation, target)


def read_text(text: str | Path) -> str:
    """The text itself, or the content of the file that it names.

    Raises
    ------
    InputError
        If it names a file that is missing or is not UTF-8 text.

    Examples
    --------
    >>> read_text("I never said that.")
    'I never said that.'
    """
    if not isinstance(text, (str, Path)):
        raise InputError(f"expected a text or the path of a text file, got {type(text).__name__}")
    path = Path(text)
    one_word = len(str(text).split()) == 1
    is_name = isinstance(text, Path) or (one_word and (path.suffix.lower() in (".txt", ".lab") or os.sep in str(text)))
    try:
        is_file = path.is_file()
    except OSError:  # a text too long to be a file name
        is_file = False
    if not is_file:
        if is_name and path.is_dir():
            raise InputError(f"{text}: expected a text file, got a folder")
        if is_name:
            raise InputError(f"{text}: no such text file")
        return str(text)
    try:
        return path.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError as problem:
        raise InputError(
            f"{path}: expected UTF-8 text, got other bytes at byte {problem.start}; save it as UTF-8"
        ) from (problem)
    except OSError as problem:
        raise InputError(f"{path}: cannot be read ({problem.strerror})") from problem


def _script(text: str | Path | Script, library: CommandLibrary) -> Script:
    from mien.script.reading import read_script, read_script_file

    if isinstance(text, Script):
        return text
    if isinstance(text, Path):
        return read_script_file(text, library)
    if not isinstance(text, str):
        raise InputError(f"expected a text to say, got {type(text).__name__}")
    return read_script(text, library)


def _file_or_text(text: str | Path) -> str | Path:
    """A script file as its path, anything else as `read_text` takes it."""
    if isinstance(text, str) and len(text.split()) == 1 and text.lower().endswith(_DOCUMENTS):
        return Path(text)
    if isinstance(text, Path) and text.suffix.lower() in _DOCUMENTS:
        return text
    return read_text(text)


def _layer(edits: EditLayer | str | Path | None) -> EditLayer:
    if edits is None or isinstance(edits, EditLayer):
        return edits or EMPTY
    if not isinstance(edits, (str, Path)):
        raise InputError(f"expected a layer of edits or the path of its file, got {type(edits).__name__}")
    return read_layer(edits)


def _library(commands: str | Path | Sequence[str | Path]) -> CommandLibrary:
    return CommandLibrary.of(*([commands] if isinstance(commands, (str, Path)) else commands))


def prepared(
    performer: Performer | str | Path = "default",
    emotion: Emotions = None,
    fps: Rate = DEFAULT_FPS,
    seed: int = 0,
    prosody: float | str = DEFAULT_STRENGTH,
    speech_model: str | None = None,
    alive: str = "all",
) -> tuple[Performer, Score, FrameRate]:
    """What `say` makes of the options that concern the performance: performer, direction for the whole, frame rate.

    Raises
    ------
    InputError
        If an option is not understood.
    """
    return _prepared(performer, speech_model, emotion, fps, seed, prosody, alive)


def _prepared(
    performer: Performer | str | Path,
    speech_model: str | None,
    emotion: Emotions,
    fps: Rate,
    seed: int,
    prosody: float | str,
    alive: str = "all",
) -> tuple[Performer, Score, FrameRate]:
    """Check every option before any long work begins."""
    if seed < 0:
        raise InputError(f"a seed is a whole number, 0 or more, not {seed}")
    rate, score = FrameRate.of(fps), _score(emotion)
    if not isinstance(performer, Performer):
        performer = load_performer(performer, speech_model)
    elif speech_model is not None:
        raise InputError("a performer that is loaded has its speech model: give load_performer(name, speech_model)")
    performer.expression.check(score)
    performer = replace(performer, prosody=AuthoredProsody(_strength(prosody)))
    if alive != "all":
        performer = replace(performer, idle=AuthoredIdle.of(alive))
    return performer, score, rate


def _strength(prosody: float | str) -> float:
    if isinstance(prosody, str) and prosody.strip().lower() == "off":
        return 0.0
    try:
        return float(prosody)
    except (TypeError, ValueError) as problem:
        raise InputError(f"visual prosody is 'off' or a number from 0 to 1, not {prosody!r}") from problem


def _score(emotion: Emotions) -> Score:
    if emotion is None:
        return Score()
    asked = (emotion,) if isinstance(emotion, (str, EmotionSpan)) else emotion
    if not isinstance(asked, Sequence) or not all(isinstance(span, (str, EmotionSpan)) for span in asked):
        raise InputError(f"an emotion is a text such as 'happy:0.6', an EmotionSpan, or several, not {emotion!r}")
    return Score(tuple(span for one in asked for span in _spans(one)))


def _spans(asked: str | EmotionSpan) -> tuple[EmotionSpan, ...]:
    """One emotion, or all those of a file of MPEG-4 expression parameters."""
    if isinstance(asked, EmotionSpan):
        return (asked,)
    if ":" not in asked and asked.strip().lower().endswith(".csv"):
        return read_expression_parameters(asked.strip())
    return (EmotionSpan.parse(asked),)


def _split_auto(emotion: Emotions) -> tuple[Emotions, bool]:
    """What is asked for besides ``"auto"``, and whether that is among it."""
    asked = (emotion,) if isinstance(emotion, str) else emotion
    if not isinstance(asked, Sequence):
        return emotion, False
    named = [span for span in asked if not (isinstance(span, str) and span.strip().lower() == "auto")]
    return (named, True) if len(named) < len(asked) else (emotion, False)


def score_with_voice(score: Score, audio: Audio) -> tuple[Score, Note]:
    """A score with the emotions that are read from a voice besides, and a note on what was read."""
    from mien.models.emotion_over_time import emotion_spans

    spans = emotion_spans(audio)
    told = [
        f"{span.name} from {span.start or 0.0:.2f} to {audio.duration if span.end is None else span.end:.2f} s"
        for span in spans
    ]
    note = Note("note", "emotion read from the voice: " + (", ".join(told) or "none that is sure, so neutral"))
    return replace(score, emotions=(*score.emotions, *spans)), note


def _sound(audio: str | Path | Audio) -> tuple[Audio, tuple[Note, ...]]:
    if isinstance(audio, Audio):
        return audio, ()
    if not isinstance(audio, (str, Path)):
        raise InputError(f"expected a sound or the path of a sound file, got {type(audio).__name__}")
    return read_audio(audio)


def _heard(
    audio: str | Path | Audio, text: str | Path | None, language: str | Path | None = None, song: bool = False
) -> Utterance:
    """Words and phones of a sound, with the notes on reading it."""
    said = read_text(text) if text is not None else None
    if said is not None and not said.strip():
        raise InputError(
            "expected a text that says what is spoken, got an empty one; leave it out to have it recognised"
        )
    if song and said is None:
        raise InputError("a song needs its lyrics: give them with --text (words are not recognised in songs)")
    audio, notes = _sound(audio)
    if said is None:
        from mien.speech.languages.language import ENGLISH
        from mien.speech.recognise import recognise

        utterance = recognise(audio, language=str(language or ENGLISH))
    elif song:
        from mien.speech.languages.language import ENGLISH
        from mien.speech.song import align_song

        utterance = align_song(audio, said, language=language or ENGLISH)
    else:
        from mien.speech.align import align as force_align
        from mien.speech.languages.language import ENGLISH

        utterance = force_align(audio, said, language=language or ENGLISH)
    if not song:
        from mien.speech.song import note_on_singing

        notes = (*notes, *note_on_singing(audio))
    return utterance.with_notes(*notes)
