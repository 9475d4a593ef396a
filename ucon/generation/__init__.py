"""Making habit datasets: propose entries, validate placements in PyBullet, verify labels against the text."""
