"""What is known of the errors of detectors: missed things, wrong names, and boxes on nothing."""
