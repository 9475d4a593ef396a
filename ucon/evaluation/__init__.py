"""Evaluation: play stored episodes on worker processes, record, measure, compare, draw."""
