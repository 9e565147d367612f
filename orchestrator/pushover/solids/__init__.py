"""The bodies as elastic solids: stiffness, mass, nodal loads, tie bars."""
