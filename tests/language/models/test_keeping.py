"""Which label is kept with some things: habits support it if their words fit, and only the label they are about."""

import time

import numpy as np
import pytest

from tests.language.tiny_models import INJECTED
from ucon.fitting.language.location_cases import asked, place_cases
from ucon.fitting.language.location_model import target_scores
from ucon.language.choice import Option, Question
from ucon.language.encoder import MiniLM
from ucon.language.labels import label_set
from ucon.language.models.encoder import EncoderModel
from ucon.language.models.keeping import LocationWeights, furniture_names
from ucon.language.store import StoredEncoder, default_encoder, shipped_table

LABELS = ("wallet", "kettle", "hammer", "apple")
HABITS = ("The wallet is on the desk.", "Tea is at five, as it always was.")
OFFICE, KITCHEN = ("desk", "swivel chair", "laptop"), ("oven", "sink", "fridge")


@pytest.fixture(scope="module")
def encoder(tmp_path_factory):
    return StoredEncoder(MiniLM(), tables=(shipped_table(),), folder=tmp_path_factory.mktemp("text"))


@pytest.fixture(scope="module")
def model(encoder):
    return EncoderModel(encoder=encoder)


def place(things, habits=HABITS, labels=LABELS):
    return Question(labels[0], tuple(habits), tuple(Option(x, (x,)) for x in labels), "", "", things=tuple(things))


def scores(model, *questions):
    return [np.array(answer.scores) for answer in model.answer(questions)]


def plain(question, encoder, w):
    """The formula of the module, written out."""

    def vector(text):
        return encoder.encode([text])[0].astype(np.float64)

    labels, things, habits, furniture = (
        [vector(text) for text in texts] for texts in (LABELS, question.things, question.habits, furniture_names())
    )
    out, places = [], (things, furniture)
    for label in labels:
        number = said = 0.0
        for h in habits:
            odds = np.exp(w.named / w.about) + sum(np.exp(other @ h / w.about) for other in labels)
            share = np.exp(label @ h / w.about) / odds
            there, usual = (np.mean([np.exp((o @ h - w.other * (o @ label)) / w.sigma) for o in x]) for x in places)
            number += share
            said += share * there / usual
        lift = np.mean([label @ o for o in things]) - np.mean([label @ f for f in furniture])
        out.append(w.weight * np.log((w.doubt + said) / (w.doubt + number)) if habits else w.like * lift)
    return np.array(out) - np.log(np.exp(out).sum())


@pytest.mark.parametrize("habits", [HABITS, HABITS[:1], ()])
@pytest.mark.parametrize("things", [OFFICE, KITCHEN, ("sofa",)])
def test_it_computes_its_formula(encoder, habits, things):
    one = place(things, habits)
    for weights in (LocationWeights(), LocationWeights(5.0, 0.2, 0.1, 0.3, 0.2, 1.5, 0.7)):
        (found,) = scores(EncoderModel(encoder=encoder, keeping=weights), one)
        assert found == pytest.approx(plain(one, encoder, weights), abs=1e-4)
        assert np.exp(found).sum() == pytest.approx(1.0, abs=1e-3)


def test_a_habit_raises_its_label_where_it_fits_and_not_elsewhere(model):
    told_office, told_kitchen, office, kitchen, others = scores(
        model, place(OFFICE), place(KITCHEN), place(OFFICE, HABITS[1:]), place(KITCHEN, HABITS[1:]), place(OFFICE)
    )
    assert told_office[0] > office[0] + 0.3
    assert told_kitchen[0] < kitchen[0]
    assert told_office[0] > told_kitchen[0] + 0.3
    assert np.ptp((others - office)[1:]) < 0.05  # the other labels change only by normalisation


def test_habits_about_other_things_change_little(model):
    many = ("The umbrella hangs by the front door.", "Grandmother's glasses are always on the piano.")
    told, alone = scores(model, place(OFFICE, (*HABITS, *many)), place(OFFICE))
    assert told == pytest.approx(alone, abs=0.1)


def test_without_habits_things_that_are_alike_attract(model):
    kitchen, office = scores(model, place(KITCHEN, ()), place(OFFICE, ()))
    assert kitchen[1] > office[1]


def test_the_target_may_stand_anywhere_among_the_labels(model):
    first, last = scores(model, place(OFFICE), place(OFFICE, labels=LABELS[::-1]))
    assert first == pytest.approx(last[::-1], abs=1e-4)


def test_company_and_order_change_no_byte(encoder, model):
    many = [place(OFFICE), place(KITCHEN), place(OFFICE, ()), place(KITCHEN[:1]), place(OFFICE, HABITS[:1])]
    many += [Question("wallet", HABITS, (Option("sofa"), Option("desk")), "", "")]
    first = [answer.scores for answer in model.answer(many)]
    assert [answer.scores for answer in reversed(model.answer(many[::-1]))] == first
    assert [EncoderModel(encoder=encoder).answer([one])[0].scores for one in many] == first


def test_a_thing_told_twice_counts_once(model):
    once, twice = scores(model, place(OFFICE), place((*OFFICE, "desk")))
    assert (once == twice).all()


def test_options_without_or_with_several_labels(model):
    options = (Option("wallet"), Option("x", ("kettle", "hammer")), Option("apple", ("apple",)))
    (pooled,) = scores(model, Question("wallet", HABITS, options, "", "", things=OFFICE))
    (apart,) = scores(model, place(OFFICE))
    assert pooled == pytest.approx([apart[0], np.logaddexp(apart[1], apart[2]), apart[3]], abs=3e-4)


def test_names_that_no_catalogue_holds_and_junk(model):
    junk = ("家 \ud800", "", "\u202e\x00zzz", "a " * 2000)
    one = Question(
        "flux capacitor", junk, (Option("flux capacitor"), Option("\ud83d"), Option("")), "", "", things=junk
    )
    (answer,) = model.answer([one])
    assert answer.choice in (0, 1, 2)
    assert np.exp(answer.scores).sum() == pytest.approx(1.0, abs=1e-3)
    (injected,) = scores(model, place(OFFICE, INJECTED))
    assert np.isfinite(injected).all()


def test_label_set_starts_with_the_target():
    labels = label_set("coffee_cup", 20)
    assert labels == label_set("coffee_cup", 20)
    assert (labels[0], len(set(labels))) == ("coffee cup", 20)
    assert label_set("coffee_cup", 1) == ("coffee cup",)


@pytest.fixture(scope="module")
def found():
    return place_cases("test", 150)


def test_habits_tell_the_true_place(found):
    hit = {}
    for level in ("none", "full", "gt", "retrieval"):
        by_place = target_scores(found, level, EncoderModel())
        hit[level] = (np.logaddexp.reduce(by_place, 1) - by_place[:, 0]).mean()
    for level in ("full", "gt", "retrieval"):
        assert hit[level] < hit["none"] - 0.01, hit
    assert hit["gt"] < np.log(4) - 0.04


@pytest.mark.timed
def test_a_decision_costs_milliseconds(found):
    model, first, later = EncoderModel(encoder=default_encoder()), [], []
    for case in found[:15]:
        for number in range(5):
            start = time.perf_counter()
            model.answer(asked(case, "full"))
            (later if number else first).append(time.perf_counter() - start)
    assert np.median(first) < 0.1
    assert np.median(later) < 0.003
