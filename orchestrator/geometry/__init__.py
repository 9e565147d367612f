"""Outlines, planar maps and polyhedra: points and edges, whatever they are of."""
