"""Which run ``train.py`` trains: a new one, or one to resume."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from ucon.configuration.known_options import TRAINING, check_options
from ucon.configuration.old_names import in_todays_names
from ucon.configuration.stored import checked, has_to_be_said
from ucon.core.device import torch_device
from ucon.core.errors import ConfigError, DataError, brief
from ucon.core.files import canonical_json, sha256_bytes, write_atomic
from ucon.core.untrusted.yaml_text import without_aliases
from ucon.learning.run.run_folder import CONFIG, read_config
from ucon.learning.run.run_plan import Plan

if TYPE_CHECKING:
    from omegaconf import DictConfig

#: Advice about a stored configuration that cannot be used.
_REMEDY = "restore it, or start a new run"
#: Options that do not change what is learned, only where and how a run is shown.
NEUTRAL_OPTIONS = ("out", "resume", "runner", "progress", "wandb", "tensorboard")


@dataclass(frozen=True)
class ChosenRun:
    """A run's configuration and folder.

    Args:
        config: resolved, as plain data.
        folder: of the run.
        checkpoint: name of the checkpoint to resume from; "" for a new run.
        steps: new length of the run in steps; None: as planned.
        stored: for a resumed run, its configuration exactly as its file has it: names of older versions are part of
            the run's identity.
    """

    config: dict[str, Any]
    folder: Path
    checkpoint: str = ""
    steps: int | None = None
    stored: Mapping[str, Any] | None = None


def chosen_run(cfg: DictConfig, overrides: Sequence[str], swept: Path | None) -> ChosenRun:
    """The new run that ``cfg`` describes, or the one that ``cfg.resume`` names.

    Args:
        cfg: composed configuration; ``resume`` is a run's folder or one of its checkpoints.
        overrides: options given on the command line.
        swept: folder of this run in a sweep; None outside a sweep.

    Raises:
        ConfigError: nothing to resume there, options besides ``resume`` that would make it another run, fewer steps,
            or options of a new run that are missing or wrong.
        DataError: a stored configuration that cannot be used.
    """
    from omegaconf import OmegaConf

    if not cfg.resume:
        if cfg.learner is None:
            raise ConfigError("learner has no value; give learner=retriever")
        _check_agent(cfg, overrides)
        config: Any = OmegaConf.to_container(cfg, resolve=True, throw_on_missing=True)
        if not config.get("out"):
            raise ConfigError("out has no value; give out=FOLDER")
        _check(config, "configuration")
        if isinstance(config["training"], Mapping) and "extended" in config["training"]:
            raise ConfigError("training.extended is for resumed runs only; give resume=RUN training.steps=MORE")
        check_options(config, TRAINING)
        return ChosenRun(config, swept or Path(str(config["out"])))
    said = _said(word for word in overrides if word.startswith("++"))
    more = [word for word in overrides if word.split("=")[0].lstrip("+") == "training.steps"]
    known = {*NEUTRAL_OPTIONS[1:], *said}
    odd = [word for word in overrides if word not in more and not {_option(word), _option(word).split(".")[0]} & known]
    if odd:
        raise ConfigError(
            f"resume={cfg.resume}: a resumed run keeps its own configuration; leave out {' '.join(odd)} "
            "(training.steps=MORE extends it)"
        )
    path = Path(str(cfg.resume)).expanduser()
    folder, checkpoint = path, "latest"
    if path.name.startswith("step_") and not (path / CONFIG).exists():
        folder, checkpoint = path.resolve().parent.parent, path.name
    try:
        raw = read_config(folder)
    except OSError:  # no such file, or not a possible file name
        raise ConfigError(f"resume={cfg.resume}: no run there (no config.yaml); give the folder of a run") from None
    config = _stored(folder / CONFIG, raw, said)
    _check_device(config["learner"], str(cfg.resume))
    steps = None
    if more:
        steps = Plan(cfg.training.steps).steps
        Plan.of(config["training"]).extend(0, steps)  # an early check; TrainingRun.resume checks against the steps done
    watched = {name: cfg[name] for name in ("progress", "wandb", "tensorboard")}
    watched["runner"] = OmegaConf.to_container(cfg.runner, resolve=True)
    return ChosenRun({**config, **watched}, folder, checkpoint, steps, _parsed(folder / CONFIG, raw))


def _option(word: str) -> str:
    return word.split("=")[0].lstrip("+~")


def write_extension(folder: Path, plan: Plan) -> None:
    """Write the extensions of a plan into the run's ``config.yaml``; nothing else in it changes."""
    from omegaconf import OmegaConf

    config = _parsed(folder / CONFIG, read_config(folder))
    config["training"]["extended"] = [one.to_json() for one in plan.extended]
    write_atomic(folder / CONFIG, OmegaConf.to_yaml(OmegaConf.create(config)))


def _said(words: Iterable[str]) -> dict[str, Any]:
    """Values given with ``++`` for options that a stored run must not decide."""
    from hydra.core.override_parser.overrides_parser import OverridesParser

    found = [OverridesParser.create().parse_override(word) for word in words]
    return {over.key_or_group: over.value() for over in found if has_to_be_said(over.key_or_group)}


def _check_device(learner: Mapping[str, Any], resume: str) -> None:
    """Refuse to resume a run on another device: results would differ.

    Raises:
        ConfigError: torch does not see the run's device here.
    """
    for name in ("device", "play_device"):
        device = learner.get(name, "cpu")
        try:
            torch_device(device)
        except ConfigError:
            raise ConfigError(
                f"resume={resume}: it was started with learner.{name}={brief(device)}, which torch does not see here; "
                "resume it where torch sees one, or start a new run"
            ) from None


#: Options of agents that concern playing, and what to give instead in training.
_OF_PLAYING: Final = {
    "agent.checkpoint": "learner.initial=FOLDER, the weights that training begins with",
    "agent.device": "learner.device",
    "agent.sample": "learner.validation.sample, how validation episodes are played",
    "agent.temperature": "it to eval.py",
}


def _check_agent(cfg: DictConfig, overrides: Sequence[str]) -> None:
    """Refuse agents without a policy, agents named for a learner that trains no policy, and options only for playing.

    Raises:
        ConfigError: naming what to give.
    """
    from omegaconf import DictConfig, OmegaConf

    name = str(cfg.learner.get("_target_", "")).rsplit(".", 1)[-1]
    if "policy" not in cfg.learner:
        if any(word.startswith("agent") for word in overrides):
            raise ConfigError(f"agent with {name}, which trains no policy; give learner=imitation, dagger or ppo")
    elif not isinstance(OmegaConf.select(cfg, "agent.policy"), DictConfig):
        target = str(cfg.agent.get("_target_", "")).rsplit(".", 1)[-1]
        raise ConfigError(f"{target} has no policy that could be trained; choose an agent that has one, such as vtn")
    for word in overrides:
        if (option := _option(word)) in _OF_PLAYING:
            raise ConfigError(f"{word}: {option} is for playing only; give {_OF_PLAYING[option]}")


def _stored(path: Path, raw: bytes, said: Mapping[str, Any]) -> dict[str, Any]:
    """The configuration that a run stored as ``raw``, checked.

    Raises:
        DataError: it is no YAML, lacks something, or would build what it must not.
        ConfigError: a value has to be given again, or was given but differs from the stored one.
    """
    config = in_todays_names(_parsed(path, raw), str(path))
    allowed: dict[str, Any] = checked(config, str(path), ("learner",), said, "++")
    try:
        check_options(config, TRAINING)
    except ConfigError as error:
        raise DataError(f"{path}: {error}; {_REMEDY}") from None
    if allowed != config:
        raise ConfigError(f"{path}: the run has other values than ++{', ++'.join(said)}; give its own")
    return allowed


def _parsed(path: Path, raw: bytes) -> dict[str, Any]:
    """The options in ``raw``.

    Raises:
        DataError: it is no UTF-8, no YAML, or lacks something.
    """
    from omegaconf import OmegaConf
    from omegaconf.errors import OmegaConfBaseException
    from yaml import YAMLError

    try:
        config: Any = OmegaConf.to_container(OmegaConf.create(without_aliases(raw.decode("utf-8"))))
    except UnicodeDecodeError:
        raise DataError(f"{path}: not UTF-8; {_REMEDY}") from None
    except YAMLError as error:
        line = mark.line + 1 if (mark := getattr(error, "problem_mark", None)) else 1
        raise DataError(f"{path}:{line}: not YAML; {_REMEDY}") from None
    except (ValueError, RecursionError, OmegaConfBaseException):
        raise DataError(f"{path}: not the configuration of a run; {_REMEDY}") from None
    try:
        _check(config, str(path))
    except ConfigError as error:
        raise DataError(f"{error}; {_REMEDY}") from None
    return dict(config)


def _check(config: Any, where: str) -> None:
    """Refuse a configuration without the options that every run needs."""
    if not isinstance(config, dict):
        raise ConfigError(f"{where}: no options in it")
    if missing := [key for key in ("learner", "training", "threads") if key not in config]:
        raise ConfigError(f"{where}: no {missing[0]} in it")
    learner = config["learner"]
    if not (isinstance(learner, dict) and isinstance(learner.get("_target_"), str)):
        raise ConfigError(f"{where}: learner has no _target_")


def learner_name(learner: Mapping[str, Any]) -> str:
    """Name of a configuration's learner as in ``learner=``: ``ppo``, ``image_goal``, ``searches``, ...

    Args:
        learner: the mapping ``learner`` of the configuration.
    """
    env = learner.get("env")
    of_env = env["config"].get("_target_", "") if isinstance(env, Mapping) and "config" in env else ""
    if str(of_env).endswith("ImageGoalEnv"):
        return "image_goal"
    if learner.get("demonstrator"):
        return "searches"
    if learner.get("expert"):
        return "dagger_searches"
    name = str(learner["_target_"]).rsplit(".", 1)[-1].removesuffix("Learner")
    return "ppo_episodes" if name == "EpisodePPO" else name.lower()


def run_identity(config: Mapping[str, Any]) -> dict[str, str]:
    """Hash of the options that decide what is learned; the learner adds hashes of its data.

    Extensions are left out: checkpoints state which of them they depend on.
    """
    learned = {key: value for key, value in config.items() if key not in NEUTRAL_OPTIONS}
    if isinstance(training := learned.get("training"), Mapping):
        learned["training"] = {key: value for key, value in training.items() if key != "extended"}
    return {"config": sha256_bytes(canonical_json(learned).encode())}


def use_threads(threads: Any) -> None:
    """Set the number of torch's threads. Sums depend on it, so it is part of the configuration.

    Args:
        threads: from 1 up.

    Raises:
        ConfigError: not a permitted number.
    """
    import torch

    check_options({"threads": threads}, TRAINING)
    torch.set_num_threads(threads)
