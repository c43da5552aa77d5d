"""The process: materials, wheels and machines, and one stroke or one dress as equations. No G-code in here."""
