"""Motion as a stream: frames paced by a clock, sent to engines and browsers."""
