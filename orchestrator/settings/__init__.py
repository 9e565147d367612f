"""The case file: what may be asked, read and checked, counted, and written out as a reference."""
