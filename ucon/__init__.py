"""UcON: user-centric object navigation. Finding things where this person keeps them.

``import gymnasium, ucon`` or ``gymnasium.make("ucon:UcON-v0")`` is enough to make an environment. Nothing heavy is
imported until one is made, and Gymnasium only where the program has imported it already.
"""

import sys

__version__ = "0.2.0"

if "gymnasium" in sys.modules:
    import ucon.envs  # noqa: F401 (registers UcON-v0)
