"""Habits of households: sentences, the placements they support, knowledge bases and datasets (paper, section III)."""

from ucon.habits.book import BOOK_FOLDER, book, contexts_book, parse_book, read_anchors
from ucon.habits.hosting import Hosted, hosted, household
from ucon.habits.knowledge import KnowledgeBase
from ucon.habits.official import ImportReport, Located, ReleaseProblem, official
from ucon.habits.splits import category_split, split_categories
from ucon.habits.types import Entry, Habit, HabitDataset, Placement
from ucon.objects.model import RELATIONS, Relation

__all__ = [
    "BOOK_FOLDER",
    "RELATIONS",
    "Entry",
    "Habit",
    "HabitDataset",
    "Hosted",
    "ImportReport",
    "KnowledgeBase",
    "Located",
    "Placement",
    "Relation",
    "ReleaseProblem",
    "book",
    "category_split",
    "contexts_book",
    "hosted",
    "household",
    "official",
    "parse_book",
    "read_anchors",
    "split_categories",
]
