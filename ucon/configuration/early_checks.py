"""Refuses a learner's wrong options before the learner is imported: importing torch and TorchRL takes seconds."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields
from typing import Any, Final

from ucon.configuration.arguments import arguments_of
from ucon.core.errors import ConfigError, brief
from ucon.learning.run import options
from ucon.learning.run.options import LearnerOptions

#: Classes of options by the learner's target; a test compares them with what the learners themselves say.
OPTIONS: Final[Mapping[str, type[LearnerOptions]]] = {
    "ucon.learning.belief_head.learner.BeliefLearner": options.BeliefOptions,
    "ucon.learning.counterfactual.learner.CounterfactualLearner": options.DecisionOptions,
    "ucon.learning.episodes.learner.EpisodePPOLearner": options.CollectingOptions,
    "ucon.learning.foresight.learner.ForesightLearner": options.DecisionOptions,
    "ucon.learning.imitation.dagger.DaggerLearner": options.DaggerOptions,
    "ucon.learning.imitation.learner.ImitationLearner": options.ImitationOptions,
    "ucon.learning.judge.learner.JudgeLearner": options.JudgeOptions,
    "ucon.learning.ppo.learner.PPOLearner": options.PPOOptions,
    "ucon.learning.retriever.learner.RetrieverLearner": options.RetrieverOptions,
}


def check_early(learner: Mapping[str, Any]) -> None:
    """Refuse values that the class of a learner's options refuses; parts and other arguments are left to the learner.

    Args:
        learner: configuration with ``_target_``, as plain data.

    Raises:
        ConfigError: naming the option and what is expected.
    """
    target = str(learner.get("_target_"))
    kind = OPTIONS.get(target)
    if kind is None:
        return
    given = {field.name: learner[field.name] for field in fields(kind) if field.name in learner}
    for name, (expected, default) in arguments_of(f"{kind.__module__}.{kind.__name__}").items():
        if name in given and given[name] is not default and not expected.takes(given[name]):
            owner = target.rpartition(".")[2]
            raise ConfigError(
                f"{owner}.{name}={brief(given[name])}: expected {expected.expected}; see its file in configs/"
            )
    if "steps" in given:  # the one that has no default
        kind(**given)
