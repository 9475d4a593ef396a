"""From proposals to a dataset: propose, validate in PyBullet, verify against the text."""
