"""The page *Play*: a person searches under the same rules as agents."""
