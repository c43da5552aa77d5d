"""The safety study: returns and violations of agents and rules beside a budget of scrap."""
