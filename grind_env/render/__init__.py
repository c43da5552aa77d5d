"""Tables and plots of what was ground; matplotlib is imported only when a plot is made."""
