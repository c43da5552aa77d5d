"""The dress study: dress intervals, dresser settings and dress triggers compared."""
