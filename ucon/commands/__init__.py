"""The commands of ``python -m ucon``, one file each. Heavy imports happen inside functions."""
