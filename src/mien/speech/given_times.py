"""Words and phones whose times somebody has given, as in a corrected TextGrid: they are taken as they are.

Phones may be ARPAbet (``AH0``, as the Montreal Forced Aligner and mien write them) or IPA; those of another language
are in its own signs (``docs/languages.md``). Where only words have times, their phones are aligned inside each word.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from pathlib import Path

from mien.core.audio import Audio
from mien.core.errors import InputError, Note, unknown_name
from mien.core.timeline import Interval, Tier
from mien.core.utterance import PAUSE, Utterance
from mien.speech.align import align
from mien.speech.recognise import ipa_phones
from mien.text.languages import find_language, in_english_phones, read_words
from mien.text.languages.language import ENGLISH, Language
from mien.text.phones import phone_table

__all__ = ["spoken_as_given"]

_WORD_TIERS = ("words", "word", "ort", "ort-mau", "orthography", "transcript", "transcription")
_PHONE_TIERS = ("phones", "phone", "phonemes", "phoneme", "mau", "segments", "segment")
_SILENCES = frozenset({"", "sil", "sp", "spn", "<p:>", "_", "#", "pau", "<eps>", "silence"})
_CLOSE = 0.005
"""Seconds: gaps and overlaps up to here are those of rounding."""


def spoken_as_given(
    audio: Audio, tiers: Sequence[Tier], *, names: Sequence[str] = (), language: str | Path | None = None
) -> Utterance:
    """An utterance with the words and phones of tiers, at their times.

    Parameters
    ----------
    audio : Audio
    tiers : sequence of Tier
        Seconds from the start of the sound.
    names : sequence of str
        Names of the tier of words and of the tier of phones, or of one of them; empty: found by their common names.
    language : str, Path or None
        What is spoken; None: English.

    Returns
    -------
    Utterance
        ``timing`` is ``"given"``.

    Raises
    ------
    InputError
        If neither tier is there, a label is no phone of the language, or a time lies outside the sound; the message
        names the tier, the label and the time.
    """
    words, phones = _words_and_phones(tiers, names)
    other = find_language(language)
    notes = _in_time(audio, [tier for tier in (words, phones) if tier is not None])
    said = _spoken_only(words) if words is not None else Tier("words", ())
    text = " ".join(word.label for word in said)
    if phones is None:
        return _phones_inside(audio, said, text, language).with_notes(*notes)
    covering = _covering(phones, audio.duration)
    tag = ENGLISH if other is None else other.tag
    if other is None:
        english = Tier("phones", tuple(_in_arpabet(covering)))
        return Utterance(text, audio, said, english, str(language or tag), "given", notes)
    _check_signs(covering, other)
    english, shapes = in_english_phones(covering, other)
    return Utterance(text, audio, said, english, tag, "given", notes, native=covering, shapes=shapes)


def _words_and_phones(tiers: Sequence[Tier], names: Sequence[str]) -> tuple[Tier | None, Tier | None]:
    known = [tier.name for tier in tiers]
    for name in names:
        if name not in known:
            raise unknown_name("tier", name, known)
    chosen = [tier for tier in tiers if tier.name in names] if names else list(tiers)
    words = next((tier for tier in chosen if _is_called(tier, _WORD_TIERS)), None)
    phones = next((tier for tier in chosen if _is_called(tier, _PHONE_TIERS)), None)
    if names and len(names) == 2:
        words, phones = (next(tier for tier in chosen if tier.name == name) for name in names)
    elif names and words is None and phones is None:
        words = chosen[0]
    if words is None and phones is None:
        raise InputError(
            f"expected a tier of words or phones, got {', '.join(map(repr, known)) or 'no tier'}: "
            "say which they are with --tiers WORDS,PHONES"
        )
    return words, phones


def _is_called(tier: Tier, names: Iterable[str]) -> bool:
    """Whether a tier has one of the common names; ``"Anna - words"`` has too."""
    return tier.name.lower().split(" - ")[-1].strip() in names


def _in_time(audio: Audio, tiers: Sequence[Tier]) -> tuple[Note, ...]:
    for tier in tiers:
        late = next((interval for interval in tier if interval.start > audio.duration + _CLOSE), None)
        if late is not None:
            raise InputError(
                f"tier {tier.name!r}: {late.label!r} starts at {late.start:.2f} s, after the end of the sound "
                f"({audio.duration:.2f} s): is it the TextGrid of another recording?"
            )
    return (Note("note", f"times are those of the tier{'s' * (len(tiers) > 1)} {_named(tiers)}, as given"),)


def _named(tiers: Sequence[Tier]) -> str:
    return " and ".join(repr(tier.name) for tier in tiers)


def _spoken_only(words: Tier) -> Tier:
    return Tier("words", tuple(word for word in words if word.label.strip().lower() not in _SILENCES))


def _covering(phones: Tier, duration: float) -> Tier:
    """The phones with pauses where nothing is said, from 0 to the end of the sound without gaps."""
    found: list[Interval] = []
    now = 0.0
    for phone in phones:
        start, end = min(phone.start, duration), min(phone.end, duration)
        if start > now + _CLOSE:
            found.append(Interval(now, start, PAUSE))
            now = start
        if end <= now:
            continue
        silent = phone.label.strip().lower() in _SILENCES
        found.append(Interval(now, end, PAUSE if silent else phone.label.strip()))
        now = end
    if duration > now + _CLOSE or not found:
        found.append(Interval(now, duration, PAUSE))
    elif found[-1].end < duration:
        found[-1] = replace(found[-1], end=duration)
    return Tier("phones", tuple(found))


def _in_arpabet(phones: Tier) -> Iterable[Interval]:
    known = phone_table()
    for phone in phones:
        plain = phone.label.rstrip("0123456789").upper()
        if phone.label == PAUSE or plain in known:
            yield replace(phone, label=phone.label if phone.label == PAUSE else plain)
            continue
        parts = ipa_phones(phone.label)
        if not parts:
            raise InputError(
                f"the phone {phone.label!r} at {phone.start:.3f} s is neither ARPAbet nor an IPA sign that is known: "
                "correct it, or say with --language what is spoken"
            )
        step = phone.duration / len(parts)
        for number, label in enumerate(parts):
            end = phone.end if number == len(parts) - 1 else phone.start + (number + 1) * step
            yield Interval(phone.start + number * step, end, label)


def _check_signs(phones: Tier, language: Language) -> None:
    for phone in phones:
        if phone.label != PAUSE:
            try:
                language.segments(phone.label)
            except InputError as problem:
                raise InputError(f"{problem} (at {phone.start:.3f} s)") from problem


def _phones_inside(audio: Audio, words: Tier, text: str, language: str | Path | None) -> Utterance:
    """The phones of words whose times are given: aligned as ever, then fitted into each word's own time."""
    if not words.intervals:
        raise InputError("the tier of words holds no word")
    aligned = align(audio, text, language=language or ENGLISH)
    counts = [len(read_words(word.label, language).words) for word in words]
    owners = [number for number, count in enumerate(counts) for _ in range(count)]
    if len(owners) != len(aligned.words):
        raise InputError(
            f"the words of the tier are read as {len(aligned.words)} together and as {len(owners)} one by one: "
            "write numbers and short forms out as words"
        )
    spans = _spans_of(aligned, owners)
    native = aligned.native is not None
    phones = _moved(aligned.spelled_phones if native else aligned.phones, spans, words)
    covering = _covering(phones, audio.duration)
    if not native:
        return replace(aligned, words=words, phones=covering, timing="given")
    found = find_language(language)
    assert found is not None
    english, shapes = in_english_phones(covering, found)
    return replace(aligned, words=words, phones=english, native=covering, shapes=shapes, timing="given")


def _spans_of(aligned: Utterance, owners: Sequence[int]) -> list[tuple[float, float]]:
    """Where the aligner found each given word, seconds."""
    spans: dict[int, tuple[float, float]] = {}
    for owner, word in zip(owners, aligned.words, strict=True):
        spans[owner] = (spans.get(owner, (word.start, 0.0))[0], word.end)
    return [spans[owner] for owner in sorted(spans)]


def _moved(phones: Tier, spans: Sequence[tuple[float, float]], words: Tier) -> Tier:
    moved = []
    for (first, last), word in zip(spans, words, strict=True):
        scale = word.duration / max(last - first, 1e-6)
        for phone in phones:
            if phone.label != PAUSE and phone.start < last - 1e-6 and phone.end > first + 1e-6:
                start = word.start + (max(phone.start, first) - first) * scale
                moved.append(Interval(start, word.start + (min(phone.end, last) - first) * scale, phone.label))
    return Tier("phones", tuple(moved))
