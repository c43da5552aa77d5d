"""The TOML reader: `tomllib` of the standard library, or where there is none (Python 3.10) the package it came from."""

import sys

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

__all__ = ["tomllib"]
