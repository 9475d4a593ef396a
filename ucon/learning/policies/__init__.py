"""The interface of policies (arrays in, logits and a value out), how they are played, batched and validated."""
