"""Names of the channels that move a face.

`ARKIT` are Apple's 52 blendshape locations, in the order in which Live Link Face writes them; values run 0..1.
`TONGUE` are shapes of the tongue that ARKit lacks and a talking mouth needs; values run 0..1.
`MUSCLES` are shapes that FACS asks for and ARKit lacks (`mien.core.facs` says which unit uses which); values run 0..1.
`BEYOND_ARKIT` are both; a face that lacks one of them does not move there, and writers that cannot hold it say so.
`HEAD` are rotations of the head in degrees about the neck, applied yaw, then pitch, then roll (intrinsic):
yaw > 0 turns to the speaker's left, pitch > 0 looks up, roll > 0 tips towards the speaker's left shoulder.
Left and right are the speaker's own.
"""

from __future__ import annotations

__all__ = ["ALL", "ARKIT", "BEYOND_ARKIT", "HEAD", "MOUTH", "MUSCLES", "TONGUE", "UPPER_FACE", "WEIGHTS"]

ARKIT: tuple[str, ...] = (
    "eyeBlinkLeft",
    "eyeLookDownLeft",
    "eyeLookInLeft",
    "eyeLookOutLeft",
    "eyeLookUpLeft",
    "eyeSquintLeft",
    "eyeWideLeft",
    "eyeBlinkRight",
    "eyeLookDownRight",
    "eyeLookInRight",
    "eyeLookOutRight",
    "eyeLookUpRight",
    "eyeSquintRight",
    "eyeWideRight",
    "jawForward",
    "jawRight",
    "jawLeft",
    "jawOpen",
    "mouthClose",
    "mouthFunnel",
    "mouthPucker",
    "mouthRight",
    "mouthLeft",
    "mouthSmileLeft",
    "mouthSmileRight",
    "mouthFrownLeft",
    "mouthFrownRight",
    "mouthDimpleLeft",
    "mouthDimpleRight",
    "mouthStretchLeft",
    "mouthStretchRight",
    "mouthRollLower",
    "mouthRollUpper",
    "mouthShrugLower",
    "mouthShrugUpper",
    "mouthPressLeft",
    "mouthPressRight",
    "mouthLowerDownLeft",
    "mouthLowerDownRight",
    "mouthUpperUpLeft",
    "mouthUpperUpRight",
    "browDownLeft",
    "browDownRight",
    "browInnerUp",
    "browOuterUpLeft",
    "browOuterUpRight",
    "cheekPuff",
    "cheekSquintLeft",
    "cheekSquintRight",
    "noseSneerLeft",
    "noseSneerRight",
    "tongueOut",
)
TONGUE: tuple[str, ...] = ("tongueTipUp", "tongueBackUp", "tongueBladeUp", "tongueCurl")
MUSCLES: tuple[str, ...] = (
    "browInnerUpLeft",
    "browInnerUpRight",
    "noseFlareLeft",
    "noseFlareRight",
    "noseCompressLeft",
    "noseCompressRight",
    "nasolabialDeepenLeft",
    "nasolabialDeepenRight",
    "mouthSharpPullLeft",
    "mouthSharpPullRight",
    "mouthTightenLeft",
    "mouthTightenRight",
)
BEYOND_ARKIT: tuple[str, ...] = TONGUE + MUSCLES
WEIGHTS: tuple[str, ...] = ARKIT + BEYOND_ARKIT
HEAD: tuple[str, ...] = ("headYaw", "headPitch", "headRoll")
ALL: tuple[str, ...] = WEIGHTS + HEAD
MOUTH: tuple[str, ...] = (
    tuple(n for n in ARKIT if n.startswith(("jaw", "mouth")) or n in ("cheekPuff", "tongueOut"))
    + TONGUE
    + tuple(n for n in MUSCLES if n.startswith(("mouth", "nasolabial")))
)
UPPER_FACE: tuple[str, ...] = tuple(n for n in WEIGHTS if n not in MOUTH)
