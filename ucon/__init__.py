"""UcON: user-centric object navigation. Finding things where this person keeps them.

``import gymnasium, ucon`` or ``gymnasium.make("ucon:UcON-v0")`` is enough to make an environment. Nothing heavy is
imported until one is made, and Gymnasium only where the program has imported it already. ``ucon.make_episode`` makes a
search in a home of one's own.
"""

import sys
from typing import TYPE_CHECKING

from ucon.core.lazy import lazy_names

if TYPE_CHECKING:
    from ucon.envs.own_home import make_episode

__all__ = ["__version__", "make_episode"]
__version__ = "0.2.0"
__getattr__ = lazy_names(__name__, {"ucon.envs.own_home": ("make_episode",)})

if "gymnasium" in sys.modules:
    import ucon.envs  # noqa: F401 (registers UcON-v0)
