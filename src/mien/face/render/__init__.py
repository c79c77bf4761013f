"""Headless rendering without any system package: a camera, a studio's lights, and a rasteriser for the processor."""
