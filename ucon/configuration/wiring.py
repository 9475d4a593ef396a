"""From configuration to objects: picklable factories for workers, and habit datasets by path."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ucon.configuration.arguments import check_arguments
from ucon.core.errors import ConfigError, UconError
from ucon.core.output import say_once

if TYPE_CHECKING:
    from ucon.habits import HabitDataset


@dataclass(frozen=True)
class Factory:
    """Builds the object that a configuration with ``_target_`` describes, a new one at each call.

    Plain data, so it can be pickled and sent to a worker.

    Args:
        config: the mapping.
        extra: further arguments that are objects already.
    """

    config: dict[str, Any]
    extra: Mapping[str, Any] = field(default_factory=dict)

    def __call__(self, **more: Any) -> Any:
        """Build the object.

        Args:
            **more: further arguments that are objects already, or that take the place of configured ones.

        Raises:
            ConfigError: the target or an argument does not exist, or a value is of the wrong type.
            UconError: raised by the constructor, unchanged.
        """
        from hydra.errors import InstantiationException
        from hydra.utils import instantiate

        check_arguments(self.config)
        try:
            # Partial, so that Hydra resolves the configuration but does not process `extra`.
            return instantiate(self.config | {"_partial_": True}, _convert_="all")(**self.extra, **more)
        except InstantiationException as error:
            _raise_users_error(error.__cause__, self.config["_target_"])
            raise
        except TypeError as error:
            _raise_users_error(error, self.config["_target_"])
            raise


def _raise_users_error(error: BaseException | None, target: str) -> None:
    """Raise the :class:`UconError` among the causes, or one about ``target`` or a wrong argument.

    Return if there is none.
    """
    while error is not None:
        if isinstance(error, UconError):
            raise error from None
        if isinstance(error, TypeError) and "argument" in str(error):
            raise ConfigError(f"{target}: {' '.join(str(error).split())}; see its file in configs/") from None
        if isinstance(error, ModuleNotFoundError) and error.name:
            raise ConfigError(f"{target}: {_missing(target, error.name)}") from None
        error = error.__cause__


def _missing(target: str, module: str) -> str:
    """The problem, in words, where importing ``target`` fails for lack of ``module``."""
    owner, _, name = target.rpartition(".")
    if module == target:
        return f"{owner} has no {name}; see its file in configs/"
    if target.startswith(f"{module}."):
        return f"there is no module {module}; see its file in configs/"
    return f"it needs the module {module}, which is not installed"


def official_habits(path: str) -> HabitDataset:
    """Dataset of the official release, without entries that are not in the catalogue.

    Prints one line about what is left out, and one if most sentences are not English. Placements are judged by shapes,
    so that sampling gives the same on every machine; the sampler tries each placement anyway. ``habits import`` reports
    what trying them in PyBullet gives.

    Args:
        path: task file, or the folder that holds it.

    Raises:
        ConfigError: there is no such path.
        DataError: the file is damaged.
    """
    from ucon.generation.kept import shape_verdicts
    from ucon.habits import official
    from ucon.objects.catalogue import catalogue

    dataset, report = official(existing(path, "habits.path"), catalogue().names)
    if (lost := report.left_out(len(dataset))) is not None:
        say_once(f"warning: {lost}")
    _warn_of_language(dataset)
    return replace(dataset, verdicts=shape_verdicts(dataset))


def folder_habits(path: str, task: str = "paper") -> HabitDataset:
    """Dataset of a file of ``habits build``, of a folder in the habit book's format, or of a home file.

    Placements of a folder are not validated.

    Args:
        path: the file or folder, or the name of a shipped home.
        task: rule set of the episodes, for a home.

    Raises:
        ConfigError: there is no such path.
        DataError: a category that is not in the catalogue, or a violation of the format.
    """
    from ucon.envs.own_home import is_home_file, own_set
    from ucon.habits.book import read_book
    from ucon.habits.datafile import SUFFIX, load_dataset_file
    from ucon.objects.catalogue import catalogue
    from ucon.task.own_home.shipped import is_shipped

    if is_home_file(path):
        return own_set(Path(path) if is_shipped(path) else existing(path, "habits.path"), task).dataset
    found = existing(path, "habits.path")
    read = load_dataset_file if found.name.endswith(SUFFIX) else read_book
    dataset = read(found, catalogue().names)
    _warn_of_language(dataset)
    return dataset


def _warn_of_language(dataset: HabitDataset) -> None:
    from ucon.language.english import language_warning

    texts = [habit.text for entry in dataset.entries for habit in entry.habits]
    if (warning := language_warning(dataset.name, texts)) is not None:
        say_once(warning)


def existing(path: str, option: str) -> Path:
    """``path`` as an existing path.

    Args:
        path: as given; ``~`` is expanded.
        option: name of the option, for the error.

    Raises:
        ConfigError: there is nothing at ``path``.
    """
    found = Path(path).expanduser()
    if not found.exists():
        raise ConfigError(f"{option}={path}: no such file or folder; give the path of an existing one")
    return found


def load_dataset(path: str | None) -> HabitDataset:
    """The dataset at a path.

    Args:
        path: a built file (``*.habits.xz``), a task file (JSON) of the official release, or a book folder; None: the
            shipped habit book.

    Raises:
        ConfigError: there is no such path.
        DataError: the dataset is damaged.
    """
    from ucon.habits import book
    from ucon.habits.datafile import SUFFIX

    if path is None:
        return book()
    found = existing(path, "PATH")
    is_book = found.name.endswith((SUFFIX, ".txt")) or (found.is_dir() and any(found.glob("*.txt")))
    return folder_habits(path) if is_book else official_habits(path)
