"""``learner=imitation`` and ``learner=dagger``: doing what is shown."""
