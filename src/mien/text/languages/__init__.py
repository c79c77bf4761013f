"""Languages other than English: how they are read, and what their phones are in the terms of the models."""

from mien.text.languages.language import Language, Segment, find_language, known_languages
from mien.text.languages.language_timing import heard_as, in_english_phones, native_tier
from mien.text.languages.reading import read_in, read_words

__all__ = [
    "Language",
    "Segment",
    "find_language",
    "heard_as",
    "in_english_phones",
    "known_languages",
    "native_tier",
    "read_in",
    "read_words",
]
