"""Training of agents with PyTorch: `gru_ppo` trains one, `command` is `grind train`."""
