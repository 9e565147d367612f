"""One increment's equations, Newton's method on them, the linear system (PETSc)."""
