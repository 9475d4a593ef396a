"""The page *Play*: a person searches, by the rules that agents search by."""
