"""The track "plants": policies that adapt to out-of-model machines, with few safe trials."""
