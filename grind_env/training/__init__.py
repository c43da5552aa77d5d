"""Training of agents, which needs PyTorch: `gru_ppo` trains one, and `command` is `grind train`."""
