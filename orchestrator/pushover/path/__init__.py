"""From increment to increment: step control, prediction, motion, what is kept, checks."""
