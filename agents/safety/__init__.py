"""Safety study: returns and violations of agents and rules with a budget of scrap."""
