"""`Animation`, the one lossless thing to keep, and the layer of edits that a person lays over it."""
