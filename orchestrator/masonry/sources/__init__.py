"""Files and drawings -> Wall: block files, DXF, SVG, rows, annotated images, pictures."""
