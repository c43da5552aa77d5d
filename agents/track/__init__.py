"""The track "plants": what adapts to machines that are not the model, with few safe trials."""
