"""How advice holds on machines that are not the model: the study of calibration, search, adviser and guarded policies."""
