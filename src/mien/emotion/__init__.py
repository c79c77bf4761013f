"""Reading the emotion from a voice."""
