"""Language models behind :class:`ucon.language.choice.LanguageModel`, one per file.

Importing one is cheap: weights are read, and torch is imported, at the first question.
"""
