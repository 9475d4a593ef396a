"""Conditions of sentences, read in a told context: "at weekends" counts on a Saturday and not on a Monday."""
