"""Policies as learners see them: arrays in, logits and a value out; how they are played and validated."""
