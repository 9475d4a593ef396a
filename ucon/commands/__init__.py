"""The commands of ``python -m ucon``, one file each, and what the entry points share. Heavy imports happen inside."""
