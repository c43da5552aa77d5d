"""The safe track: what agents and rules earn, and what they violate, beside a budget of scrap."""
