"""The voices that speak a text: one interface, one file for each engine."""

from mien.speech.voices.catalogue import DEFAULT_VOICE, catalogue, get_voice
from mien.speech.voices.voice import Availability, Speech, Voice

__all__ = ["DEFAULT_VOICE", "Availability", "Speech", "Voice", "catalogue", "get_voice"]
