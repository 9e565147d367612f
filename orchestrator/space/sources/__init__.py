"""Walls in space from files of other programs: COMPAS, meshes (OBJ, PLY, STL), STEP, and plans of courses (DXF)."""
