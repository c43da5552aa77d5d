"""Default amounts of work for tuning and scoring.

It stands alone, so that the command line can show these numbers without loading the libraries that do the work.
"""

TUNING_EPISODES = 48
"""Episodes on training and on validation seeds that a scripted policy is tuned on."""
TUNING_EVALUATIONS = 700
"""Evaluations of one CMA-ES run."""
TUNING_STARTS = 4
"""CMA-ES runs of a rule."""

GAP_EPISODES = 256
"""Evaluation episodes of the table of gaps."""
STUDY_EPISODES = 256
"""Evaluation episodes of the dress study."""
STUDY_MACHINES = 3
"""Machines of each family in the study of those that are not the model."""

PICTURES = 3
"""Pictures of each block of an animation."""
