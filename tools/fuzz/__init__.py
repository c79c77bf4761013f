"""``make fuzz``: damaged and hostile files for every reader, made without end from a few sound ones."""
