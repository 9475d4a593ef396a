"""What an agent computes from its own frames.

Detections, the semantic map, places where the target may be, the belief over them, views to look from, and the planner.
"""
