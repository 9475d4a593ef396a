"""``learner=retriever``: which habits are about what."""
