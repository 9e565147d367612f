"""The paper's method: Eq. (1) and (2), the sequence of linear programs, the mechanism."""
