"""Reports: one HTML file that works offline, on wide and narrow screens and on A4 paper."""
