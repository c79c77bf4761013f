"""Files that mien writes: one adapter per format, each says what it loses."""

from mien.formats.registry import EXPORTERS, Exporter, check_output, save

__all__ = ["EXPORTERS", "Exporter", "check_output", "save"]
