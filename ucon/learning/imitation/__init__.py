"""``learner=imitation`` and ``learner=dagger``: training on labelled actions."""
