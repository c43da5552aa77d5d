"""Cost of a part over table speed and dress interval, and over lead and depth of the dress."""
