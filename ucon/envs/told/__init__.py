"""What is told in place of a household's habits: false ones among them, or single sentences taken out or changed."""
