"""From records to figures: metrics, intervals, paired differences, tables and plots."""
