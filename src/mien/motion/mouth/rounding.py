"""Lips as round as another speaker's: what one camera hardly sees is taken from recordings that show it.

A camera in front sees a mouth grow narrow and hardly sees it protrude, and some speakers round their lips little.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from mien.motion.mouth.speech_motion import SpeechMotion

__all__ = ["ROUND", "rounded"]

ROUND = ("W", "UW", "UH", "OW", "OY", "AO")
"""Phones whose lips are round."""
_PUCKER = "mouthPucker"
_THIN = ("mouthRollUpper", "mouthRollLower", "mouthFrownLeft", "mouthFrownRight")
"""What makes lips thin or draws their corners down, by which a capture may explain an upper lip that comes forward."""


def rounded(motion: SpeechMotion, like: SpeechMotion, phones: Sequence[str] = ROUND) -> SpeechMotion:
    """The same model with the lips of some key shapes as round and full as another speaker's, where that is more.

    Both learned in channels.

    Examples
    --------
    >>> from mien.motion.performers import load_learned_performer
    >>> mandarin, default = (load_learned_performer(name).motion for name in ("mandarin", "default"))
    >>> made, pucker = rounded(mandarin, default), mandarin.mouth_.names.index("mouthPucker")
    >>> bool((made.key_shapes("UW") >= mandarin.key_shapes("UW") - 1e-3)[:, pucker].all())  # never less round
    True
    """
    names, theirs = motion.mouth_.names, like.mouth_.names
    own, other = names.index(_PUCKER), theirs.index(_PUCKER)
    for phone in phones:
        shapes, round_ones = motion.key_shapes(phone), like.key_shapes(phone)
        shapes[:, own] = np.maximum(shapes[:, own], round_ones[:, other])
        for thin in (name for name in _THIN if name in names):
            most = round_ones[:, theirs.index(thin)] if thin in theirs else 0.0
            shapes[:, names.index(thin)] = np.minimum(shapes[:, names.index(thin)], most)
        motion = motion.with_key_shape(phone, shapes)
    return motion
