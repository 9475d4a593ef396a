"""Agents and policies that search homes for UcON."""
