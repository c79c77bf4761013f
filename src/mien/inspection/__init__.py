"""What a performer has learned, in words and in pictures (``mien inspect``)."""
