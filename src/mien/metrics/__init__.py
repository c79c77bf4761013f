"""How near one face in motion comes to another: one task a module, each with ``validate`` and ``evaluate``.

The shape is mir_eval's (Raffel et al. 2014): ``evaluate(reference, estimate)`` returns a dict of figures by name, the
unit at the end of the name (``_mm``, ``_ms``, ``_deg``; none: a ratio or a correlation). Whatever is compared is first
brought to common ground, a `mien.metrics.face_track.FaceTrack`. The definitions stand in ``docs/metrics.md``.
"""
