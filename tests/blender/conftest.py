"""What runs inside Blender is no module of tests."""

collect_ignore = ["in_blender.py"]
