"""Better words for a part program, and the same text with them."""
