from __future__ import annotations

from pathlib import Path

import pytest

from mien.api import calls as api
from mien.formats.native import write_native
from mien.pipeline.options import prepared
from mien.serve.modules.handlers import Interpret, Perform, Speak, Translate
from mien.serve.modules.messages import Message
from mien.text.commands import shipped_library
from tests.serve.modules.speaking import toy_voice

__all__ = ["toy_voice"]
TEXT = (
    'That is <HeadNod count="2" end="900"/> true. <pause seconds="0.5"/> <emotion name="happy" intensity="0.6">I '
    '<emphasis>really</emphasis> mean it</emotion> <gaze target="left"/> now <WinkLeft/>'
)


CURVED = (
    '<emotion name="happy" intensity="0.2@0,0.9@0.4,0.333@1.25">That is <emotion name="sad" '
    'intensity="0.1@0%,0.7@100%">true</emotion> now</emotion> and so on'
)


@pytest.mark.usefixtures("toy_voice")
@pytest.mark.parametrize(
    ("said", "emotion"), [(TEXT, None), (TEXT, "sad:0.3"), (CURVED, None), (CURVED, "angry:0.3@0,0.7@0.123456789")]
)
def test_the_pipe_gives_the_same_bits_as_say(tmp_path: Path, said: str, emotion: str | None) -> None:
    write_native(
        api.say(said, emotion=emotion, performer="hand-made", seed=3, voice="kokoro-heart"), tmp_path / "say.json"
    )
    library = shipped_library()
    performer, score, rate = prepared("hand-made", emotion, seed=3)
    perform = Perform(
        library, performer, rate, 3, score, lambda made, *_: write_native(made, tmp_path / "pipe.json") and None
    )
    text = said
    speak = Speak(library, "kokoro-heart", 3, score=score)
    for module in (Interpret(library), speak, Translate(library, lambda notes: None)):
        (text,) = module(Message(text, 1), 1)
        assert "\n" not in text
    assert not list(perform(Message(text, 1), 1))
    assert (tmp_path / "pipe.json").read_bytes() == (tmp_path / "say.json").read_bytes()
