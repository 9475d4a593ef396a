"""Networks of the learned policies: blocks that they share."""
