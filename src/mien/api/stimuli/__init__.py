"""Stimuli for experiments: one table of factors in, videos or pictures with a log of every frame out."""

from mien.api.stimuli.design import Stimulus, read_design
from mien.api.stimuli.stimulus_making import StimuliReport, make_stimuli

__all__ = ["StimuliReport", "Stimulus", "make_stimuli", "read_design"]
