"""The same work on many machines, by Ray: evaluation, labelling, the making of lives, and the collecting of experience.

Homes and episode sets travel as packs; workers that die or hang are replaced. No result depends on who made it.
"""
