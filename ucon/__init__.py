"""UcON: user-centric object navigation. Finding things where this person keeps them.

``import ucon`` registers the Gymnasium environments; nothing heavy is imported until one is made.
"""

__version__ = "0.1.0"
