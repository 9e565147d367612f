"""Files and drawings -> Wall: block files, DXF, SVG, rows, annotated images, pictures."""

DRAWINGS, VECTORS, ROWS = (".dxf",), (".svg",), (".txt", ".rows")
PICTURES = (".png", ".jpg", ".jpeg", ".tif", ".tiff", ".bmp", ".gif")
"""endings of the files that `import` reads, beside block files"""
