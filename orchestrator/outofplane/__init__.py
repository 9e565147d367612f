"""Walls in space for the commands: case file, limit and check, pictures, and the page with the collapse to turn."""
