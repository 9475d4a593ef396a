"""Ground floor: frames, seeded random streams, typed errors, atomic files with checksums."""
