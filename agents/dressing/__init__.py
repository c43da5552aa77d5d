"""The dress study: how a wheel should be dressed."""
