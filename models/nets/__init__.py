"""Blocks that learned policies are built of."""
