"""Seeded mutations of the product: what the suite notices when a line of it is wrong."""
