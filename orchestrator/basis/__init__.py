"""What every room stands on: arrays, units, errors, files, processes, which program this is."""
