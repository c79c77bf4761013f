"""Motion served while it is wanted: the live stream, the four modules as programs, the studio."""
