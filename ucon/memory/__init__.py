"""What a robot that stays in a home keeps from one request to the next."""
