"""How an animation shows itself in a notebook: as a small video with its sound."""

from __future__ import annotations

import html
from base64 import b64encode
from pathlib import Path

from mien.animation.animation import Animation
from mien.core.temporary_folder import temporary_folder

__all__ = ["html_of"]

WIDTH, HEIGHT = 480, 480
LONGEST = 20.0
"""Seconds; a longer one is a contact sheet and a sound, which take no minutes to draw."""


def html_of(animation: Animation) -> str:
    """An animation on the default face as HTML that needs nothing from outside.

    Examples
    --------
    >>> from tests.faces import tiny_animation  # doctest: +SKIP
    >>> html_of(tiny_animation())[:6]  # doctest: +SKIP
    '<video'
    """
    from mien.face.library import load_face
    from mien.face.render.view import View
    from mien.formats.contact_sheet import write_contact_sheet
    from mien.formats.video import write_video
    from mien.formats.wav import write_sound

    face, said = load_face("default"), html.escape(animation.utterance.text)
    with temporary_folder() as folder:
        if animation.utterance.duration <= LONGEST:
            video = folder / "line.mp4"
            write_video(animation, face, video, view=View(WIDTH, HEIGHT))
            shown = f'<video controls width="{WIDTH}" src="{_inline(video, "video/mp4")}"></video>'
        else:
            sheet, sound = folder / "line.png", folder / "line.wav"
            write_contact_sheet(animation, face, sheet)
            write_sound(animation.utterance.audio, sound)
            shown = (
                f'<img width="900" src="{_inline(sheet, "image/png")}">'
                f'<br><audio controls src="{_inline(sound, "audio/wav")}"></audio>'
            )
    notes = "".join(f"<br><small>{html.escape(note.message)}</small>" for note in animation.notes)
    return f"{shown}<br>{said}{notes}"


def _inline(path: Path, kind: str) -> str:
    return f"data:{kind};base64,{b64encode(path.read_bytes()).decode()}"


Animation.html_of = staticmethod(html_of)
