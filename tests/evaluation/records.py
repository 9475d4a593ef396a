"""Records made by hand for tests of what reads them."""

from dataclasses import replace

from ucon.evaluation.play import Played
from ucon.evaluation.record import EpisodeRecord, EpisodeTiming

BASE = EpisodeRecord(
    episode="e0",
    scene="Rs_int",
    split="seen",
    target="coffee_cup",
    relation="inside",
    contained=True,
    agent="belief",
    habit_level="retrieval",
    seed=0,
    success=True,
    success_75=True,
    success_150=True,
    success_300=True,
    spl=0.5,
    soft_spl=0.5,
    shortest_path_m=2.0,
    path_length_m=4.0,
    steps=30,
    actions="0012305" + "6",
    opens=1,
    collisions=0,
    first_seen_step=20,
    failure_cause="none",
    n_habits=20,
    recall_10=0.5,
    recall_20=0.75,
    mrr=1.0,
)


def record(number: int, *, success: bool = True, **changes: object) -> EpisodeRecord:
    if not success:
        failed = {"success_75": False, "success_150": False, "success_300": False, "spl": 0.0, "soft_spl": 0.1}
        changes = {"success": False, "failure_cause": "never_seen", "steps": 300, **failed, **changes}
    return replace(BASE, episode=f"e{number}", **changes)  # type: ignore[arg-type]


def played(number: int, **changes: object) -> Played:
    made = record(number, **changes)  # type: ignore[arg-type]
    return Played(number, made, EpisodeTiming(made.episode, 0.5 + number))
