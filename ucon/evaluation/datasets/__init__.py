"""Figures and plots of habit datasets, and surveys among people about them."""
