"""The studio: a server on this machine and a page in the browser, to direct a line by eye (``docs/studio.md``)."""
