"""The FE pushover of elastic bodies in no-tension frictional contact (dolfinx, PETSc)."""
