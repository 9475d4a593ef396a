"""Networks of the learned policies and the layers that they share."""
