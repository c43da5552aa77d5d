"""What a part costs over table speed and dress interval, and over lead and depth of the dress."""
