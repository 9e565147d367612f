"""What people look at: report pages, pictures, tables, the verdict."""
