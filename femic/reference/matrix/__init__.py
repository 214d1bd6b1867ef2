"""C on a grid: the IC matrix of each body at all lags and strips."""
