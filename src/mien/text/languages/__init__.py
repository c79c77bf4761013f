"""Languages other than English: how they are read, and what their phones are in the terms of the models."""

from mien.text.languages.language import Language, Segment, find_language, known_languages, read_words
from mien.text.languages.language_timing import heard_as, in_english_phones, native_tier

__all__ = [
    "Language",
    "Segment",
    "find_language",
    "heard_as",
    "in_english_phones",
    "known_languages",
    "native_tier",
    "read_words",
]
