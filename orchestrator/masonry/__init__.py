"""The wall as drawn: blocks, where they come from, and what they must satisfy."""
