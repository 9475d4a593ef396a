"""Names in configurations of older versions, and what they are called now.

Stored runs are read for years while code moves. A stored configuration is read as if it had been written today;
everything that reads one (:mod:`ucon.configuration.stored`) uses these tables.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

from ucon.core.errors import DataError, brief

#: Constructors that moved or were renamed: today's name by the old one.
MOVED: Final[Mapping[str, str]] = {
    "models.nets.advice.Advisor": "models.nets.end_to_end.advice.Advisor",
    "models.nets.belief_head.BeliefHead": "models.nets.belief.belief_head.BeliefHead",
    "models.nets.clip_eye.ClipEye": "models.nets.vision.clip_eye.ClipEye",
    "models.nets.detr_tokens.DetrTokens": "models.nets.vision.detr_tokens.DetrTokens",
    "models.nets.goals.ClipGoal": "models.nets.vision.goals.ClipGoal",
    "models.nets.goals.SentenceGoal": "models.nets.vision.goals.SentenceGoal",
    "models.nets.head_reader.HeadReader.load": "models.nets.belief.head_reader.HeadReader.load",
    "models.nets.resnet18.FrozenResNet18": "models.nets.vision.resnet18.FrozenResNet18",
    "models.nets.tokens.LabelTokens": "models.nets.vision.local_tokens.LabelTokens",
    "ucon.commands.wiring.Factory": "ucon.configuration.wiring.Factory",
    "ucon.commands.wiring.folder_habits": "ucon.configuration.wiring.folder_habits",
    "ucon.commands.wiring.official_habits": "ucon.configuration.wiring.official_habits",
    "ucon.envs.waypoint.search_env.Returns": "ucon.envs.search.env.Returns",
    "ucon.envs.waypoint.search_env.UcONSearchEnv": "ucon.envs.search.env.UcONSearchEnv",
    "ucon.language.chat.ChatClient": "ucon.language.servers.chat.ChatClient",
    "ucon.language.models.keeping.KeepingWeights": "ucon.language.models.keeping.LocationWeights",
    "ucon.learning.belief.BeliefLearner": "ucon.learning.belief_head.learner.BeliefLearner",
    "ucon.learning.belief_data.Draw": "ucon.learning.belief_head.draws.Draw",
    "ucon.learning.collecting.InProcess": "ucon.learning.ppo.collecting.InProcess",
    "ucon.learning.collecting.InWorkers": "ucon.learning.ppo.collecting.InWorkers",
    "ucon.learning.dagger.DaggerLearner": "ucon.learning.imitation.dagger.DaggerLearner",
    "ucon.learning.dagger.Rollouts": "ucon.learning.imitation.dagger.DaggerRollouts",
    "ucon.learning.demonstrators.Searches": "ucon.learning.imitation.demonstrators.AgentDemonstrator",
    "ucon.learning.imitation.dagger.Collections": "ucon.learning.imitation.dagger.DaggerRollouts",
    "ucon.learning.imitation.demonstrators.Searches": "ucon.learning.imitation.demonstrators.AgentDemonstrator",
    "ucon.learning.imitation.ImitationLearner": "ucon.learning.imitation.learner.ImitationLearner",
    "ucon.learning.ppo.PPOLearner": "ucon.learning.ppo.learner.PPOLearner",
    "ucon.learning.ppo_loss.PPOLoss": "ucon.learning.ppo.clipped_loss.PPOLoss",
    "ucon.learning.retriever.RetrieverLearner": "ucon.learning.retriever.learner.RetrieverLearner",
    "ucon.learning.sequence_loss.SequenceLoss": "ucon.learning.imitation.sequence_loss.SequenceLoss",
    "ucon.learning.validation.Validation": "ucon.learning.policies.validation.Validation",
    "ucon.perception.detectors.open_vocabulary.Weights": "ucon.perception.detectors.open_vocabulary.DetectorWeights",
    "ucon.perception.reading.ReadHabits": "ucon.perception.belief.from_habits.ReadHabits",
}

#: Removed arguments, by today's name of the constructor: the value that had no effect.
GONE: Final[Mapping[str, Mapping[str, Any]]] = {
    "ucon.perception.belief.from_habits.ReadHabits": {"follow": 0.0},
    "ucon.learning.ppo.learner.PPOLearner": {"expert": None},
    "ucon.envs.search.env.UcONSearchEnv": {"expert": False},
}

#: Constructors that are no longer there, and why nothing takes their place.
REMOVED: Final[Mapping[str, str]] = {
    "ucon.perception.detectors.noisy.Rates": "the noisy detector now makes other errors: occlusion, scores, draws",
    "ucon.learning.foresight.ForesightLoss": "learner=foresight learns what lies beyond views instead",
    "ucon.learning.ppo.foresight.ForesightLoss": "learner=foresight learns what lies beyond views instead",
}

#: Renamed arguments, by today's name of the constructor: new name by the old one.
RENAMED: Final[Mapping[str, Mapping[str, str]]] = {
    "ucon.learning.belief_head.learner.BeliefLearner": {"own_places": "scene_evidence"},
}


def in_todays_names(node: Any, where: str) -> Any:
    """A stored configuration with today's names, at any depth.

    Args:
        node: plain data.
        where: names its file, for the error.

    Raises:
        DataError: it uses a removed constructor, or a removed argument with a value that had an effect.
    """
    if isinstance(node, list | tuple):
        return [in_todays_names(inner, where) for inner in node]
    if not isinstance(node, Mapping):
        return node
    out = {name: in_todays_names(inner, where) for name, inner in node.items()}
    target = out.get("_target_")
    if not isinstance(target, str):
        return out
    if target in REMOVED:
        raise DataError(
            f"{where}: {target} is gone ({REMOVED[target]}); play the run with the commit in its summary.json"
        )
    target = out["_target_"] = MOVED.get(target, target)
    out = {RENAMED.get(target, {}).get(name, name): value for name, value in out.items()}
    for name, nothing in GONE.get(target, {}).items():
        if name in out and out[name] != nothing:
            raise DataError(
                f"{where}: {name}={brief(out[name])} of {target} was removed, and its value had an effect; "
                "play the run with the commit in its summary.json"
            )
        out.pop(name, None)
    return out
