"""Simulator and Gymnasium environments for the surface-grinding cycles of a CNC grinder control.

Importing the package registers the environments `grind/<Task>-v0`.
"""

import sys

try:
    from grind_env.envs import register
except KeyboardInterrupt:
    # the command `grind` has to import its package before it can guard anything
    if sys.argv[0].replace("\\", "/").rpartition("/")[2] in ("grind", "grind.exe"):
        sys.exit(130)
    raise

__version__ = "0.1.0"

register()
