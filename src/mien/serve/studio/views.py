"""Cameras and lights by name, the same for the page and for pictures that are exported."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from mien.core.errors import unknown_name
from mien.face.model import Face
from mien.face.render.camera import Camera
from mien.face.render.lighting import Lighting, known_lightings
from mien.face.render.renderer import Renderer
from mien.serve.studio.requests import FieldError

__all__ = ["CAMERAS", "LIGHTS", "Shown"]

CAMERAS: dict[str, Callable[[Face, float], Camera]] = {
    "portrait": Camera.portrait,
    "three-quarter": lambda face, aspect: Camera.portrait(face, aspect).turned(32.0, 2.0),
    "profile": lambda face, aspect: Camera.portrait(face, aspect).turned(82.0),
    "mouth": Camera.close_up,
}
LIGHTS = known_lightings()


@dataclass(frozen=True)
class Shown:
    """What an export shows, and how.

    Attributes
    ----------
    face, rig : object
        Ids of the page's, checked where they are looked up; None: the default face, moved by its morph targets.
    camera, light : str
        Of `CAMERAS` and `LIGHTS`.
    """

    face: object = None
    rig: object = None
    camera: str = "portrait"
    light: str = "portrait"

    @classmethod
    def of(cls, asked: Mapping[str, Any]) -> Shown:
        """Read from a request.

        Raises
        ------
        FieldError
            If a camera or light is not known.
        """
        chosen = {"camera": CAMERAS, "light": LIGHTS}
        for field, known in chosen.items():
            name = asked.get(field)
            if name is not None and name not in tuple(known):
                raise FieldError(field, str(unknown_name(field, str(name)[:40], known)))
        camera, light = asked.get("camera") or "portrait", asked.get("light") or "portrait"
        return cls(asked.get("face"), asked.get("rig"), camera, light)

    def renderer(self, face: Face, width: int = 1280, height: int = 720) -> Renderer:
        """What draws a face so."""
        camera = CAMERAS[self.camera](face, width / height)
        return Renderer(face, width, height, camera, Lighting.named(self.light))
