"""Files and drawings -> Wall: block files, DXF, SVG, rows, annotated images, pictures."""

DRAWINGS = (".dxf",)
"""endings of files with layers"""
VECTORS = (".svg",)
"""endings of drawings with groups"""
ROWS = (".txt", ".rows")
"""endings of row notation"""
PICTURES = (".png", ".jpg", ".jpeg", ".tif", ".tiff", ".bmp", ".gif")
"""endings of pictures of the stones"""
