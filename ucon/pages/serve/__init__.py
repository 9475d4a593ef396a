"""``python -m ucon serve``: pages on this machine alone, for runs, homes, habits, play and studies.

Starlette and Uvicorn are imported here and nowhere else: ``pip install 'ucon-nav[serve]'``.
"""
