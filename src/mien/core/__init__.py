"""The ground floor: time, sound, tracks of markers and channels, what is said, errors, files.

Nothing here knows a face, a model or a file format.
"""
