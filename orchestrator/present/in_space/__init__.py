"""Walls in space to look at: pictures, and the page with the collapse to turn."""
