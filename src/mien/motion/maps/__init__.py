"""Maps that turn recorded motion in one emotion into the same speech in another."""
