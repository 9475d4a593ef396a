"""Networks that learned policies are made of."""
