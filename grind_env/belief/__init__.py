"""What can be known of wheel and lot from what was measured."""
