"""Faces in other people's glTF files: read, recognised, told about, and laid out to be drawn."""
