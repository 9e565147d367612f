"""Blocks in space and their limit analysis: polyhedra, joints between faces, second-order cones for friction.

    block_files, sources, generators, floors -> SpaceWall -> contacts, ties: SpaceAssemblage -> loads -> equilibrium ->
    conic_program (associative), elastic_joints (headline; springs, stiffness, interior_step), descent (range) ->
    validation -> mechanism

The plane analysis (orchestrator.limit_analysis) stays as it is for plane walls loaded in their plane.
"""
