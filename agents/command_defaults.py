"""Default amounts of work for tuning and scoring.

This module imports nothing, so the command line shows these numbers without loading the libraries that do the work.
"""

TUNING_EPISODES = 48  #: number of training episodes, and of validation episodes, for tuning a scripted policy
TUNING_EVALUATIONS = 700  #: number of evaluations in a CMA-ES run
TUNING_STARTS = 4  #: number of CMA-ES runs for a rule

GAP_EPISODES = 256  #: number of evaluation episodes of the table of gaps
STUDY_EPISODES = 256  #: number of evaluation episodes of the dress study
STUDY_MACHINES = 3  #: number of machines of each family in the study of out-of-model machines

PICTURES = 3  #: number of pictures per block of an animation
