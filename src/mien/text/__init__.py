"""What is asked for: scripts (tags, XML, SSML, BML), commands, how text is read aloud, pronunciation, languages."""
