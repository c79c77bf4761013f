"""The speaking mouth: learned curves, the papers' co-articulation, hand-made key shapes, closures."""
