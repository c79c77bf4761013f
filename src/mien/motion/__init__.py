"""What moves, and why: mouth, expression, maps between emotions, signs of life; `Performer` bundles them."""
