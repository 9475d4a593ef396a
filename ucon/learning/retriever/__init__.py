"""``learner=retriever``: fine-tunes the sentence encoder for retrieval."""
