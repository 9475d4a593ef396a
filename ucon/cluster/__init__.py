"""Evaluating, labelling, making lives and collecting experience on many machines, with Ray.

Homes and episode sets are sent as packs; workers that die or hang are replaced. No result depends on which worker
made it.
"""
