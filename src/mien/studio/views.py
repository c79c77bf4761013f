"""Cameras and lights by name, the same for the page and for pictures that are exported."""

from __future__ import annotations

__all__ = ["CAMERAS", "LIGHTS"]

CAMERAS: tuple[str, ...] = ("portrait",)
LIGHTS: tuple[str, ...] = ("portrait",)
