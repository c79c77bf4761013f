"""Recordings of sound and face motion, checked and ready to learn from."""
