"""Simulator and Gymnasium environments for the surface-grinding cycles of a CNC grinder control.

Importing the package registers the environments `grind/<Task>-v0`.
"""

from grind_env.envs import register

__version__ = "0.1.0"

register()
