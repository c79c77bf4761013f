"""Compile what would otherwise be compiled while somebody waits for a first picture."""

from __future__ import annotations

import numpy as np

from mien.core import channels
from mien.core.audio import Audio
from mien.core.compiled import cache_note
from mien.core.timeline import Interval, Tier
from mien.face.deformers import deformed_by, poser_for
from mien.face.library import load_face
from mien.face.render.renderer import Renderer
from mien.formats.video import luma_and_chroma
from mien.motion.mouth.speech_model import synthesise
from mien.motion.performers import load_learned_performer, load_performer

__all__ = ["warm_up"]

_SIDE = 64  # pixels: the size of a picture changes nothing of what is compiled


def warm_up() -> str:
    """Use each kernel of drawing, posing and the performers' models once, so that it is compiled and kept.

    Takes about half a minute where nothing is kept yet, and two seconds afterwards. Run it once after an installation;
    without it the first picture takes that long.

    Returns
    -------
    str
        One line: where the compiled kernels are kept.
    """
    face = load_face("default")
    still = np.zeros(len(channels.ALL))
    for shown in (face, deformed_by(face, "tree")):
        picture = Renderer(shown, _SIDE, _SIDE).render(poser_for(shown, channels.ALL).pose(still))
        luma_and_chroma(picture, np.empty((_SIDE * 3 // 2, _SIDE), np.uint8))
    sound = Audio.silence(0.6, 16_000)
    said = [Interval(0.0, 0.2, "SIL"), Interval(0.2, 0.4, "AA"), Interval(0.4, 0.6, "SIL")]
    for name in load_learned_performer("default").speech_models:
        model = load_learned_performer("default").model(name)
        synthesise(model, Tier("phones", tuple(said)), np.arange(18) / 30, sound)
    load_performer("default")
    return cache_note()
