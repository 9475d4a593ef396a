"""The base of all packages: frames, seeded random streams, typed errors, atomic files with checksums."""
