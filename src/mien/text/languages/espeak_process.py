"""A program of its own: speak with eSpeak NG's library. Never imported by mien, only run.

eSpeak NG is GPL-3. This script uses the Python standard library alone, is started as a separate process with
``python -I``, loads the library found on the machine, and talks through its standard input and output only.

In: one line of JSON, ``{"library", "data", "voice", "speed", "ipa", "sentences": [text, ...], "words": [text, ...]}``;
``sentences`` are spoken, for ``words`` only the phones are asked; ``ipa`` says whether phones have IPA signs or the
engine's own names. All but ``library``, ``data`` and ``voice`` may be left out.
Out: one line of JSON, ``{"rate", "sentences": [{"samples", "phones": [[sample, name], ...], "words": [[sample,
character], ...]}, ...], "words": [[phone, ...], ...]}``, then the samples of all sentences, 16 bit, native byte order.
A phone lasts until the next. Phones of ``words`` are in IPA.
"""

import ctypes
import json
import sys
from typing import Any

SYNCHRONOUS = 2
PHONE_EVENTS, IPA_EVENTS, DO_NOT_EXIT = 0x0001, 0x0002, 0x8000
IPA, SEPARATOR = 0x02, "_"
UTF8, CHARACTER = 1, 1
RATE_PARAMETER = 1
END_OF_LIST, WORD, PHONE = 0, 1, 7


class Identity(ctypes.Union):
    """What an event is about: for a phone, up to eight bytes of its name."""

    _fields_ = [("number", ctypes.c_int), ("name", ctypes.c_void_p), ("string", ctypes.c_char * 8)]


class Event(ctypes.Structure):
    """espeak_EVENT of speak_lib.h."""

    _fields_ = [
        ("type", ctypes.c_int),
        ("unique_identifier", ctypes.c_uint),
        ("text_position", ctypes.c_int),
        ("length", ctypes.c_int),
        ("audio_position", ctypes.c_int),
        ("sample", ctypes.c_int),
        ("user_data", ctypes.c_void_p),
        ("id", Identity),
    ]


CALLBACK = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.POINTER(ctypes.c_short), ctypes.c_int, ctypes.POINTER(Event))


class Recorder:
    """Gathers the samples and events of one sentence."""

    def __init__(self, rate: int) -> None:
        self.rate = rate
        self.samples = bytearray()
        self.phones: list[tuple[int, str]] = []
        self.words: list[tuple[int, int]] = []

    def take(self, wave: Any, count: int, events: Any) -> int:
        """The library's callback; 0 means go on."""
        if wave and count:
            self.samples += ctypes.string_at(wave, 2 * count)
        number = 0
        while events[number].type != END_OF_LIST:
            event = events[number]
            place = event.audio_position * self.rate // 1000
            if event.type == PHONE:
                self.phones.append((place, event.id.string.decode("utf-8", "replace")))
            elif event.type == WORD:
                self.words.append((place, event.text_position - 1))
            number += 1
        return 0


def phones_of(espeak: Any, word: str) -> list[str]:
    """The phones of one word in IPA, with the marks of stress."""
    espeak.espeak_TextToPhonemes.restype = ctypes.c_char_p
    text = ctypes.create_string_buffer(word.encode("utf-8"))
    place = ctypes.c_void_p(ctypes.addressof(text))
    found: list[str] = []
    while place.value:
        said = espeak.espeak_TextToPhonemes(ctypes.byref(place), UTF8, IPA | ord(SEPARATOR) << 8) or b""
        found += said.decode("utf-8", "replace").replace(" ", SEPARATOR).split(SEPARATOR)
    return [phone for phone in found if phone]


def main() -> None:
    """Answer one request."""
    request = json.loads(sys.stdin.readline())
    espeak = ctypes.CDLL(request["library"])
    data = request["data"].encode() if request["data"] else None
    events = PHONE_EVENTS | (IPA_EVENTS if request.get("ipa") else 0)
    rate = espeak.espeak_Initialize(SYNCHRONOUS, 0, data, events | DO_NOT_EXIT)
    if rate <= 0 or espeak.espeak_SetVoiceByName(request["voice"].encode()) != 0:
        sys.exit(f"eSpeak NG cannot start with the voice {request['voice']}")
    if "speed" in request:
        espeak.espeak_SetParameter(RATE_PARAMETER, request["speed"], 0)
    words = [phones_of(espeak, word) for word in request.get("words", ())]
    answers, sound = [], bytearray()
    for text in request.get("sentences", ()):
        recorder = Recorder(rate)
        callback = CALLBACK(recorder.take)
        espeak.espeak_SetSynthCallback(callback)
        raw = text.encode("utf-8")
        if espeak.espeak_Synth(raw, ctypes.c_size_t(len(raw) + 1), 0, CHARACTER, 0, UTF8, None, None) != 0:
            sys.exit("eSpeak NG could not speak the sentence")
        answers.append({"samples": len(recorder.samples) // 2, "phones": recorder.phones, "words": recorder.words})
        sound += recorder.samples
    answer = {"rate": rate, "sentences": answers, "words": words}
    sys.stdout.buffer.write(json.dumps(answer).encode() + b"\n" + bytes(sound))


if __name__ == "__main__":
    main()
