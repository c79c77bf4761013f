"""Expressions: recorded or hand-made performances, their space, and new motion sampled from it."""
