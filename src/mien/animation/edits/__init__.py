"""Edits by hand as a layer over what was made: tied to words and phones, laid on again when the line changes.

No model is here: the room works on utterances, scores and tracks (``docs/edits.md``).
"""

from mien.animation.edits.applied import AppliedEdits, Lost
from mien.animation.edits.edited_line import Line, LineWord, line_of
from mien.animation.edits.layer import EMPTY, Anchor, BorderEdit, ChannelEdit, EditLayer, IntensityEdit, Place
from mien.animation.edits.layer_file import layer_of, plain_layer, read_layer, write_layer

__all__ = [
    "EMPTY",
    "Anchor",
    "AppliedEdits",
    "BorderEdit",
    "ChannelEdit",
    "EditLayer",
    "IntensityEdit",
    "Line",
    "LineWord",
    "Lost",
    "Place",
    "layer_of",
    "line_of",
    "plain_layer",
    "read_layer",
    "write_layer",
]
