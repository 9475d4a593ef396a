"""Plays the cases of the shipped homes without and with habits, and draws each as a figure."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np

from ucon.evaluation.figures.case_strip import Strip, Waypoint, chosen_steps, draw_case
from ucon.evaluation.figures.floor_drawing import Floor
from ucon.evaluation.kept.decisions import DecisionRecord
from ucon.evaluation.kept.finished import FinishedRun
from ucon.evaluation.kept.record import EpisodeRecord
from ucon.programs.composing import eval_config
from ucon.programs.evaluating import Evaluation
from ucon.sim.cache import load_house
from ucon.sim.state import SceneState
from ucon.task.episode import Episode
from ucon.task.own_home.building import rooms_by_name
from ucon.task.own_home.places import spoken
from ucon.task.own_home.reading import read_home
from ucon.task.own_home.shipped import CASES, home_path

#: Habit levels of the searches that are drawn, and what the robot is told at each.
LEVELS: Final = {"none": "told nothing", "retrieval": "told the retrieved habits"}


@dataclass(frozen=True)
class CaseSearch:
    """One search of a case.

    Attributes:
        level: habit level.
        record: the episode's record.
        strip: the search as it is drawn.
        heard: number, from 1, of the first sentence about the target among those told; 0 where none was told.
    """

    level: str
    record: EpisodeRecord
    strip: Strip
    heard: int


def draw_cases(words: Sequence[str], out: Path, names: Sequence[str] = tuple(CASES)) -> dict[Path, list[CaseSearch]]:
    """Play cases, and draw each.

    Args:
        words: options of ``eval.py``, such as ``agent=belief`` and ``task=real_robot``.
        out: folder for the figures and the runs.
        names: of the cases.

    Returns:
        The figures, and the searches in each.

    Raises:
        ConfigError: not in a clone, a wrong option, or matplotlib is missing.
    """
    return {out / f"{name}.png": _draw_one(name, words, out) for name in names}


def _draw_one(name: str, words: Sequence[str], out: Path) -> list[CaseSearch]:
    wish = read_home(home_path(name))
    request = next(one for one in wish.requests if one.target == CASES[name].target)
    told = [habit.text for habit in request.habits]
    found = [_search(name, level, words, out, told) for level in LEVELS]
    episode, searches = found[0][0], [search for _, search in found]
    house = load_house(episode.scene)
    floor = Floor(house, SceneState(house, episode.arrangement).boxes, tuple(rooms_by_name(wish, house).values()))
    target = request.target.replace("_", " ")
    title = f"{wish.called}: find the {target}, which is {' or '.join(spoken(place) for place in request.places)}"
    caption = " ".join(f"“{text}”" for text in told)
    path = out / f"{name}.png"
    strips = [search.strip for search in searches]
    draw_case(title, caption, strips, floor, house.n_instances + episode.target, path)
    return searches


def _search(name: str, level: str, words: Sequence[str], out: Path, told: Sequence[str]) -> tuple[Episode, CaseSearch]:
    """Play a case at a habit level."""
    folder = out / "runs" / f"{name}-{level}"
    fixed = ("workers=0", "progress=false", "pictures=0")
    run = Evaluation(eval_config(*words, *fixed, f"episodes={name}", f"habit_level={level}"), folder, anew=True)
    run.play()
    kept = FinishedRun.read(run.out)
    assert kept.records is not None, "a run just played keeps its records"
    record, episode = kept.records[0], run.episodes[0]
    decisions = kept.decisions().get(record.episode, ())
    given = run.given(episode) or ()
    heard = next((number for number, text in enumerate(given, 1) if text in told), 0)
    strip = _strip(run.spec.env(), episode, record, decisions, f"{run.label}, {_told(level, len(given), heard)}")
    return episode, CaseSearch(level, record, strip, heard)


def _told(level: str, given: int, heard: int) -> str:
    if not given:
        return LEVELS[level]
    return f"{LEVELS[level]} (number {heard} of {given} is the one below)" if heard else LEVELS[level]


def _strip(
    env: Any, episode: Episode, record: EpisodeRecord, decisions: Sequence[DecisionRecord], searcher: str
) -> Strip:
    """Replay a recorded search and take pictures at its waypoints."""
    env.reset(seed=record.seed, options={"episode": episode})
    bare = env.unwrapped
    moments = [bare.moment()]
    for action in map(int, record.actions):
        env.step(action)
        moments.append(bare.moment())
    goals = {decision.step: decision.words for decision in decisions}
    ending = "found" if record.success else record.failure_cause.replace("_", " ")
    path = np.array(bare.ledger.path_xy, np.float64)
    waypoints = []
    for step in chosen_steps(list(goals), record.steps):
        picture = bare.draw(moments[step])
        frame = picture[:, : picture.shape[0]].copy()
        x, y = path[moments[step].nodes - 1].tolist()
        waypoints.append(Waypoint(step, (x, y), frame, ending if step == record.steps else goals.get(step, "begins")))
    env.close()
    title = f"{searcher}: {ending} after {record.steps} steps, {record.path_length_m:.1f} m, SPL {record.spl:.2f}"
    return Strip(title, tuple(waypoints), path)
