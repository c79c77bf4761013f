"""Cleaning of recorded marker motion: each step a pure function from track to track, and `clean.clean`, all in order.

==============  ==============================================================================================
`faults`        what is wrong with a recording before anything is done to it
`perspective`   a tracker's pixels to millimetres in mien's axes
`normalise`     the head's own motion taken out (Deng et al. 2006, and by least squares over any rigid markers)
`swaps`         two markers that changed names for a stretch
`spikes`        a marker that flew off for a few frames
`gaps`          frames in which a marker was not seen
`jitter`        the tracker's noise, without blunting the closures of the lips
`resample`      another frame rate
`lag`           by how much the motion is later than the sound
`groups`        head, upper face, mouth (Cao et al. 2005)
==============  ==============================================================================================
"""
