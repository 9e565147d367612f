"""Walls in space from a few numbers: each generator returns blocks and supports as one SpaceWall."""
