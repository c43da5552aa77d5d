"""The error of a job."""

from grind_env.process.toml_tables import TableError


class JobError(TableError):
    """A job that cannot be run."""
