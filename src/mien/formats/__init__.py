"""Files that mien writes and reads: one file a format, each says what it loses; ``registry`` knows them all."""

from mien.formats.registry import EXPORTERS, Exporter, check_output, exporters, save

__all__ = ["EXPORTERS", "Exporter", "check_output", "exporters", "save"]
