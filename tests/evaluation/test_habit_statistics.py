"""Habit statistics: definitions on small datasets, the study's figures, and the limits that the book must meet."""

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from ucon.core.errors import ConfigError
from ucon.evaluation.datasets.dataset_statistics import Measures, measure
from ucon.evaluation.datasets.homes_of_habits import measure_retrieval, offer_of_scenes
from ucon.evaluation.datasets.placements import placement_statistics
from ucon.evaluation.datasets.plots import draw_plots, require_matplotlib
from ucon.evaluation.datasets.sentences import names, near_duplicates, text_statistics
from ucon.habits import Entry, Habit, HabitDataset, Placement, book, official
from ucon.retrieval import DenseRetriever, dataset_vectors
from ucon.scenes import SCENES

RELEASE = Path(__file__).resolve().parents[2] / "../shared/official_release/task"


def small(labelled: bool = True) -> HabitDataset:
    """Two entries that disagree entirely about the mug, and a third that shares one anchor with the first."""
    desk, sink, bed = (
        Placement("ontop", "desk"),
        Placement("nextto", "sink"),
        Placement("ontop", "coffee_table", "Sundays"),
    )
    first = (Habit("My mugs live on the desk.", (0,)), Habit("Bread is late."))
    second = (Habit("She sips by the coffee tables.", (0,)), Habit("The cup dries near the tap."), Habit("It snows."))
    third = (Habit("One mug waits on the desk or at the sink.", (0, 1)),)
    return HabitDataset(
        "small",
        (
            Entry("mug/0", "mug", "a", (desk, sink), first),
            Entry("mug/1", "mug", "b", (bed,), second),
            Entry("mug/2", "mug", "a", (desk, Placement("inside", "fridge")), third),
        ),
        labelled=labelled,
    )


@pytest.mark.parametrize(
    ("text", "name", "found"),
    [
        ("On the coffee table.", "coffee_table", True),
        ("Two Coffee Tables!", "coffee_table", True),
        ("on coffee_table", "coffee_table", True),
        ("Two boxes.", "box", True),
        ("Decaffeinated coffee, tablecloth.", "coffee_table", False),
        ("A mugging.", "mug", False),
    ],
)
def test_full_phrase(text, name, found):
    assert names(text, name) is found


def test_small_text():
    figures = text_statistics(small())
    assert (figures["habits"], figures["entries"], figures["households"]) == (6, 3, 2)
    assert figures["names_target"] == pytest.approx(2 / 6, abs=1e-4)
    assert figures["names_true_anchor"] == pytest.approx(3 / 6, abs=1e-4)
    assert figures["length_tells_support"] == pytest.approx(8 / 9, abs=1e-4), "two ties of nine pairs"
    assert text_statistics(small(labelled=False))["length_tells_support"] is None


def test_small_places():
    figures = placement_statistics(small())
    assert figures["relations"] == {"ontop": 0.6, "inside": 0.2, "under": 0.0, "nextto": 0.2}
    assert figures["supporting_habits"] == 0.5
    assert figures["unsupported_placements"] == pytest.approx(1 / 5), "the first entry's sink"
    assert figures["unnamed_placements"] == pytest.approx(2 / 5), "that sink, and the fridge"
    assert figures["contradictions"] == {"pairs": 3, "disjoint": 0.6667, "mean_jaccard": round(1 / 9, 4)}
    assert figures["contexts"]["placements"] == figures["contexts"]["kinds"]["day"] == 1


def test_without_labels_support_means_that_the_anchor_is_named():
    figures = placement_statistics(small(labelled=False))
    assert figures["unsupported_by"] == "phrase"
    assert figures["unsupported_placements"] == figures["unnamed_placements"] == pytest.approx(2 / 5)
    assert figures["supporting_habits"] is None


def test_households_that_cannot_share_a_home_do_not_contradict():
    office, shop = (replace(e, kind=kind) for e, kind in zip(small().entries, ("office", "shop"), strict=False))
    assert placement_statistics(HabitDataset("s", (office, shop)))["contradictions"]["pairs"] == 0


def test_near_duplicates_count_the_later_one():
    vectors = np.eye(4, 8, dtype=np.float16)
    vectors[3] = vectors[1]
    assert near_duplicates(vectors, block=2) == 0.25


class TestBook:
    """Limits: what the project promises about its data."""

    def test_text(self):
        figures = text_statistics(book())
        assert figures["habits"] >= 23_000
        assert figures["categories"] >= 497
        assert figures["vocabulary"] >= 11_000
        assert figures["distinct_2"] >= 0.54
        assert figures["unique_masked"] >= 0.995
        assert figures["duplicates"] == 0

    @pytest.mark.slow
    def test_near_duplicates(self):
        assert near_duplicates(dataset_vectors(book(), DenseRetriever().encoder)) <= 0.002

    def test_places(self):
        figures = placement_statistics(book())
        assert figures["unsupported_placements"] <= 0.25
        assert set(figures["contexts"]["kinds"]) == {"day", "time", "season", "event", "other"}
        assert all(figures["contexts"]["kinds"].values())

    def test_every_scene_offers_forty_targets_and_hundreds_of_habits(self):
        offer = offer_of_scenes(book())
        assert set(offer.categories) == set(SCENES)
        assert min(offer.categories.values()) >= 40
        sizes = np.concatenate(list(offer.sizes["category"].values()))
        assert 300 <= sizes.min() <= sizes.max() <= 600
        assert all((offer.sizes["task"][s] < offer.sizes["category"][s]).all() for s in SCENES)


def test_retrieval_finds_what_tells_a_place_first():
    found = measure_retrieval(book(), DenseRetriever(), "task")
    assert (np.diff(found.recall) >= 0).all()
    assert found.supporting is not None
    assert found.supporting[19] > 0.7 > found.recall[19]
    assert found.mrr > 0.9


def test_the_release_measures_as_in_the_study_of_it():
    if not RELEASE.is_dir():
        pytest.skip("the official release is not on this machine")
    release = official(RELEASE)[0]
    text, places = text_statistics(release), placement_statistics(release)
    assert text["names_target"] == pytest.approx(0.416, abs=0.005)
    assert text["names_true_anchor"] == pytest.approx(0.352, abs=0.01)
    assert places["unsupported_placements"] == pytest.approx(0.31, abs=0.02)
    assert places["contradictions"]["mean_jaccard"] == pytest.approx(0.205, abs=0.01)
    assert text["households"] is None


@pytest.fixture(scope="module")
def measured() -> Measures:
    """All measures of a small part of the book."""
    return measure(replace(book(), name="part", entries=book().entries[::40]), scenes=("Rs_int",))


def test_all_figures_together(measured):
    wanted = (
        "habits categories vocabulary distinct_2 unique_masked duplicates near_duplicates mrr recall_at_10 recall_at_20"
    )
    assert set(wanted.split()) <= set(measured.figures)
    assert measured.figures["retrieval"]["task"]["supporting_recall_at_20"] > 0
    assert measured.figures["scenes"]["target_categories_by_scene"].keys() == {"Rs_int"}


def test_a_book_about_offices_is_measured_in_offices(tmp_path):
    pytest.importorskip("matplotlib", reason="an optional extra")
    bound = replace(small(), entries=tuple(replace(entry, kind="office") for entry in small().entries))
    found = measure(bound, scenes=("Rs_int", "office_large"))
    counts = found.figures["scenes"]["target_categories_by_scene"]
    assert counts == {"Rs_int": 0, "office_large": 1}
    assert found.figures["mrr"] == 1.0
    nowhere = measure(bound, scenes=("Rs_int",))
    assert nowhere.figures["scenes"] == {}
    draw_plots([found, nowhere], tmp_path)
    draw_plots([nowhere], tmp_path)
    with pytest.raises(ConfigError, match="no entry fits any of the scenes"):
        measure_retrieval(replace(bound, entries=(replace(bound.entries[0], kind="moon"),)), DenseRetriever())


@pytest.mark.parametrize("datasets", [2, pytest.param(1, marks=pytest.mark.slow)])
def test_pictures(measured, tmp_path, datasets):
    pytest.importorskip("matplotlib", reason="an optional extra")
    from PIL import Image

    for path in draw_plots([measured] * datasets, tmp_path):
        picture = np.asarray(Image.open(path).convert("L"))
        assert min(picture.shape) > 600
        assert picture.std() > 10, f"{path.name} is empty"


def test_missing_matplotlib_is_said_in_one_line(monkeypatch):
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    with pytest.raises(ConfigError, match=r"pip install 'ucon-nav\[plots\]'"):
        require_matplotlib()
