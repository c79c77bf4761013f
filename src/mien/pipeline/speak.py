"""`speak`: a script gets a voice, and everything in it a time."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

from mien.core.audio import Audio
from mien.core.errors import InputError, MienError, Note
from mien.core.timeline import Tier
from mien.core.utterance import Utterance
from mien.emotion.emotional_voice import Kept, with_feeling
from mien.pipeline.script_places import Clock, emotions_at, naming_its_line, place
from mien.pipeline.spoken import Spoken
from mien.pipeline.spoken_joining import Joined, Joiner, WordPlace, over_longer_sound, with_pauses
from mien.speech.sound_reshaping import Change, reshape
from mien.text.commands import CommandLibrary, shipped_library
from mien.text.languages import find_language, read_words
from mien.text.languages.reading import note_on_language
from mien.text.normalisation import spoken_words
from mien.text.score import UNDIRECTED, Score
from mien.text.script import Script, Segment
from mien.text.spoken_text import Spelled, SpokenText
from mien.text.sync_points import plain

__all__ = ["Listener", "Synthesiser", "speak", "speak_over"]

_RATE = 24_000  # samples per second where nothing is said
_STILL = 1.0  # seconds that a command without words is followed by
_ROOM = 0.1  # seconds after the last gesture
Synthesiser = Callable[..., Utterance]
"""Called as `mien.speech.synthesis.synthesise` is."""
Listener = Callable[[str, str | Path | None, Sequence[Spelled]], Utterance]
"""Aligns a text in a language, with pronunciations that are asked for, with a recording."""


def speak(
    script: Script,
    voice: str | None = None,
    seed: int = 0,
    library: CommandLibrary | None = None,
    language: str | Path | None = None,
    score: Score = UNDIRECTED,
    voice_emotion: float = 1.0,
    synthesiser: Synthesiser | None = None,
) -> Spoken:
    """Speak a script and give its direction times.

    Parameters
    ----------
    script : Script
    voice : str or None
        Goes before the voice that the script names for the whole; ``<voice>`` inside it goes before both.
    seed : int
    library : CommandLibrary, optional
        For the parameters that a command's length goes into.
    language : str, Path or None
        As for `mien.say`; goes before the language that the script names.
    score : Score
        What is felt besides what the script says, in seconds of the result.
    voice_emotion : float
        How much the voice goes with what is felt, 0 to 1.
    synthesiser : Synthesiser, optional
        Speaks the plain text instead of `mien.speech.synthesis.synthesise`: one that remembers, for instance.

    Raises
    ------
    InputError
        If nothing can be spoken or a time lies outside the sound.
    MissingPartError
        If a voice is not installed.
    """
    joined = _spoken(script, voice or script.voice, seed, language or script.language, synthesiser)
    carried = partial(_carried, script, voice or script.voice, language or script.language)
    felt = _felt(_reshaped(joined, script), script, score, voice_emotion, seed, carried)
    changed = _with_room(felt, script, library or shipped_library())
    return place(script, changed, library)


def speak_over(
    script: Script,
    align: Listener,
    library: CommandLibrary | None = None,
    language: str | Path | None = None,
) -> Spoken:
    """Give a script's direction the times of a recording in which its words are said.

    Parameters
    ----------
    align : callable
        Given the text, its language and the pronunciations asked for, finds words and phones in the recording.
    library : CommandLibrary, optional
    language : str, Path or None
        As for `mien.say`; goes before the language that the script names.
    """
    text, starts = "", []
    for segment in script.segments:
        text = text + " " if text and not text.endswith((" ", "\n")) else text
        starts.append(len(text))
        text += segment.text
    language = language or script.language
    asked_for = [
        (start + s.start, start + s.end, s.phones)
        for start, segment in zip(starts, script.segments, strict=True)
        for s in segment.spellings
    ]
    utterance = align(text, language, asked_for)
    spoken = read_words(text, language).words
    places = []
    for word in spoken:
        number = bisect_right(starts, word.start) - 1
        places.append(WordPlace(number, word.start - starts[number], word.end - starts[number]))
    if len(places) != len(utterance.words):
        if script.points and utterance.timing != "none":
            raise InputError("the words of the script and of the recording differ, so nothing can be placed at words")
        places = []
    asked = any(segment.silence is not None or segment.start for segment in script.segments)
    if script.prosody or asked or any(s.voice for s in script.segments):
        message = "pauses, prosody and voices of the script are not followed: the recording has its own"
        utterance = utterance.with_notes(Note("note", message))
    return place(script, Joined(utterance, tuple(places)), library)


def _spoken(
    script: Script,
    voice: str | None,
    seed: int,
    language: str | Path | None,
    synthesiser: Synthesiser | None = None,
) -> Joined:
    from mien.speech.synthesis import synthesise

    told = [n for n, s in enumerate(script.segments) if any(char.isalnum() for char in s.text)]
    if not told:
        return _silent(script)
    pieces: dict[int, tuple[Utterance, SpokenText]] = {}
    for number in told:
        segment = script.segments[number]
        spellings = [(s.start, s.end, s.phones) for s in segment.spellings]
        own, notes = _own_voice(segment.voice)
        spoken_in = None if own else language
        said = (synthesiser or synthesise)(
            segment.text, voice=own or voice, seed=seed, language=spoken_in, spellings=spellings
        )
        said = said.with_notes(*(note_on_language(segment.text) if said.native is None else ()), *notes)
        pieces[number] = said, read_words(segment.text, spoken_in, said.language)
    first, spoken = pieces[told[0]]
    alone = script.segments[told[0]]
    if len(script.segments) == 1 and alone.silence is None and alone.start is None:
        return Joined(first, tuple(WordPlace(0, word.start, word.end) for word in spoken.words))
    joiner, waiting = Joiner(first.audio.rate), 0.0
    for number, segment in enumerate(script.segments):
        silence = _silence(segment, script, joiner, waiting)
        if number not in pieces:
            waiting = silence or 0.0
            continue
        joiner.add(*pieces[number], number, silence)
        waiting = 0.0
    if waiting:
        joiner.silence(waiting)
    notes = [note for number in told[1:] for note in pieces[number][0].notes if note not in first.notes]
    return Joined(joiner.finish(first, script.text).with_notes(*notes), tuple(joiner.places))


def _own_voice(asked: str | None) -> tuple[str | None, list[Note]]:
    """The first that is there of the voices a segment asks for; None: the usual one, with a note if it has to do."""
    from mien.speech.voices import get_voice

    names = (asked or "").split()
    if len(names) < 2:
        return asked, []  # the engine tells if it is not there
    problems = list[str]()
    for name in names:
        if name == "...":
            return None, [Note("note", f"{'; '.join(problems)}; the usual voice speaks instead")]
        try:
            get_voice(name)
        except MienError as problem:
            problems.append(str(problem).partition("?")[0].partition("; known")[0])
        else:
            return name, []
    raise InputError(problems[0])


def _silence(segment: Segment, script: Script, joiner: Joiner, waiting: float) -> float | None:
    """Seconds of silence before a segment; None as the voice has it."""
    silence = segment.silence / 1000 + waiting if segment.silence is not None else (waiting or None)
    if segment.start is None:
        return silence
    so_far = Utterance("", Audio.silence(joiner.now, joiner.rate), Tier("words", tuple(joiner.words)),
                       with_pauses(joiner.phones, joiner.now), "", "voice")  # fmt: skip
    clock = Clock(Joined(so_far, tuple(joiner.places)), script.points)
    wanted = segment.start.resolve(clock.time_of) / 1000 - joiner.last
    return max(wanted, silence or 0.0)


def _silent(script: Script) -> Joined:
    """An utterance in which nothing is said, as long as its pauses and commands ask for."""
    asked = script.commands or script.curves or any(segment.silence for segment in script.segments)
    if not asked:
        spoken_words(script.text)  # says what is wrong with an empty text
    pauses = sum(segment.silence or 0.0 for segment in script.segments)
    moments = [moment for item in script.commands for moment in (item.at, item.until) if moment]
    moments += [moment for curve in script.curves for moment, _ in curve.keys]
    last = max((moment.offset for moment in moments), default=0.0)
    seconds = pauses / 1000 if pauses else last / 1000 + _STILL
    audio = Audio.silence(seconds, _RATE)
    language = script.language or "en-US"
    nothing = Utterance("", audio, Tier("words", ()), with_pauses([], audio.duration), language, "none")
    return Joined(nothing, ())


def _reshaped(joined: Joined, script: Script) -> Joined:
    if not script.prosody:
        return joined
    clock = Clock(joined, script.points)
    changes = []
    for item in script.prosody:
        start, end = item.start.resolve(clock.time_of) / 1000, item.end.resolve(clock.time_of) / 1000
        if end > start:
            changes.append(Change(start, end, item.rate or 1.0, item.pitch or 0.0, item.volume or 0.0))
    return replace(joined, utterance=reshape(joined.utterance, changes))


def _carried(script: Script, voice: str | None, language: str | Path | None) -> dict[str, float]:
    """What the voices that speak carry of an emotion: of each figure what the weakest does."""
    from mien.speech.voices import get_voice

    found: dict[str, float] = {}
    for asked in dict.fromkeys(segment.voice for segment in script.segments):
        own, _ = _own_voice(asked)
        try:
            speaker = get_voice(own or voice, None if own else find_language(language))
        except MienError:  # it has spoken: by a `Synthesiser` of the caller's, whose voices are none of the catalogue's
            continue
        for name, share in speaker.feeling.items():
            found[name] = min(share, found.get(name, 1.0))
    return found


def _felt(
    joined: Joined, script: Script, score: Score, amount: float, seed: int, carried: Callable[[], dict[str, float]]
) -> Joined:
    """Spoken with what is felt; rate, pitch and volume that the script sets stay as set."""
    if joined.utterance.timing == "none" or not (script.emotions or score.emotions):
        return joined
    clock = Clock(joined, script.points)
    kept = []
    for item in script.prosody:
        start, end = item.start.resolve(clock.time_of) / 1000, item.end.resolve(clock.time_of) / 1000
        asked = {"rate": item.rate, "pitch": item.pitch, "volume": item.volume}
        kept.append(Kept(start, end, frozenset(name for name, value in asked.items() if value is not None)))
    at_words = Score(emotions_at(script.emotions, clock))
    return replace(joined, utterance=with_feeling(joined.utterance, at_words, score, amount, kept, seed, carried()))


def _with_room(joined: Joined, script: Script, library: CommandLibrary) -> Joined:
    """Silence at the end, for commands that stand after the last word."""
    utterance, clock = joined.utterance, Clock(joined, script.points)
    if not utterance.words.intervals:
        return joined
    last_word, needed = utterance.words.intervals[-1].end * 1000, 0.0
    for item in script.commands:
        if not item.at.terms or item.at.terms[0][0].partition(".")[0] not in clock.points:
            continue
        at = naming_its_line(item.command.where, partial(item.at.resolve, clock.time_of))
        if item.until is None and last_word - 1 <= at <= utterance.duration * 1000:
            curves = library.translate(item.command.with_(at=plain(at))).curves
            needed = max(needed, *(curve.keys[-1][0] / 1000 for curve in curves))
    if needed <= utterance.duration:
        return joined
    more = Audio.silence(needed - utterance.duration + _ROOM, utterance.audio.rate)
    audio = Audio.join([utterance.audio, more])
    return replace(joined, utterance=over_longer_sound(utterance, audio))
