"""What an engineer reads off: capacity, section forces, seismic verification, sensitivity."""
