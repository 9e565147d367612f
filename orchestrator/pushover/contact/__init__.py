"""Contact between bodies: where, which laws, cohesion and mortar (numpy only)."""
