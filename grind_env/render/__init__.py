"""Tables and plots of grinding records; matplotlib is imported only for a plot."""
