"""Lips as round as another speaker's: what one camera hardly sees is taken from recordings that show it.

A camera in front sees a mouth grow narrow and hardly sees it protrude, and some speakers round their lips little.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from mien.motion.mouth.speech_motion import SpeechMotion

__all__ = ["ROUND", "SHARE", "rounded"]

ROUND = ("W", "UW", "UH", "OW", "OY", "AO")
"""Phones whose lips are round."""
SHARE = 0.3
"""Hand-made: more makes the width of the mouth vary more than a tenth more than recorded."""
_FORWARD = ("mouthPucker", "mouthFunnel")
_THIN = ("mouthRollUpper", "mouthRollLower", "mouthFrownLeft", "mouthFrownRight")
"""What makes lips thin or draws their corners down, by which a capture may explain an upper lip that comes forward."""
_DOWN = ("mouthLowerDownLeft", "mouthLowerDownRight")
_PARTS = 0.22
"""How much mouthFunnel parts the lips of the default face as far as mouthLowerDown of one side."""


def rounded(
    motion: SpeechMotion, like: SpeechMotion, phones: Sequence[str] = ROUND, share: float = SHARE
) -> SpeechMotion:
    """The same model with the lips of some key shapes as round and full as another speaker's, where that is more.

    Both learned in channels. ``share`` of the way is gone: mouthPucker and mouthFunnel come as near to theirs, and what
    draws the lower lip down more than theirs becomes a funnel, which parts the lips as far and makes them round.

    Examples
    --------
    >>> from mien.motion.performers import load_learned_performer
    >>> mandarin, default = (load_learned_performer(name).motion for name in ("mandarin", "default"))
    >>> made, pucker = rounded(mandarin, default), mandarin.mouth_.names.index("mouthPucker")
    >>> bool((made.key_shapes("UW") >= mandarin.key_shapes("UW") - 1e-3)[:, pucker].all())  # never less round
    True
    """
    names, theirs = motion.mouth_.names, like.mouth_.names
    for phone in phones:
        shapes, round_ones = motion.key_shapes(phone), like.key_shapes(phone)
        for forward in (name for name in _FORWARD if name in names and name in theirs):
            own, other = shapes[:, names.index(forward)], round_ones[:, theirs.index(forward)]
            shapes[:, names.index(forward)] += share * np.maximum(other - own, 0.0)
        for thin in (name for name in _THIN if name in names):
            most = round_ones[:, theirs.index(thin)] if thin in theirs else 0.0
            shapes[:, names.index(thin)] = np.minimum(shapes[:, names.index(thin)], most)
        for down in (name for name in _DOWN if name in names):
            theirs_down = round_ones[:, theirs.index(down)] if down in theirs else 0.0
            spare = share * np.maximum(shapes[:, names.index(down)] - theirs_down, 0.0)
            shapes[:, names.index(down)] -= spare
            if _FORWARD[1] in names:
                shapes[:, names.index(_FORWARD[1])] += _PARTS * spare
        motion = motion.with_key_shape(phone, shapes)
    return motion
