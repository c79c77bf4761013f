"""Recording a session of one's own: a script to read, sound and camera or prepared files, a folder to import."""
