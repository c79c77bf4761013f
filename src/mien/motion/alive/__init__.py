"""Signs of life: blinks and glances, the head, brows and nods on the accents of the voice."""
