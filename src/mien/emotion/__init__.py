"""Emotion and the voice: read from one that was recorded, given to one that is synthetic."""
