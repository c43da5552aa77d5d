"""How advice holds on machines that are not the model: calibration, search and adviser, on members of all families."""
