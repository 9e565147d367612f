"""States without dilation beyond the paper: what growing load leads to, and others."""
