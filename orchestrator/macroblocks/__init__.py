"""Blocks that move as one: merged by tolerances or without any, and the bodies that they become."""
