"""The report of runs: one HTML file with tables and every episode, made from what the runs' folders keep."""
