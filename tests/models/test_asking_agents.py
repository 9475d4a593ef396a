"""What LGX, PixelNav and L3MVN ask, how they use an answer, and with which models they can be played."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from models.agents.asking import PROMPTS, AskingAgent, listed
from models.agents.l3mvn import LABELS_THERE, L3MVNAgent, label_set, select
from models.agents.lgx import SIDES, LGXAgent, side_of
from models.agents.pixelnav import PixelNavAgent, angle_of, mosaic
from tests.language.tiny_models import save_causal
from tests.models.playing import SeeingEncoder, episodes, gone, play
from ucon.core.errors import ConfigError
from ucon.envs.ucon_env import UcONEnv
from ucon.language.choice import Answer
from ucon.language.models.causal_lm import CausalModel
from ucon.language.models.chat_api import ChatModel
from ucon.language.models.encoder import EncoderModel
from ucon.language.phrases import phrase
from ucon.language.prompt import Prompt
from ucon.language.servers.chat import ChatClient
from ucon.objects.catalogue import catalogue
from ucon.search import Decision

MAKERS = {
    "lgx": lambda model, **o: LGXAgent(model, temperature=0.0, **o),
    "lgx_object": lambda model, **o: LGXAgent(model, mode="object", temperature=0.0, **o),
    "lgx_warm": LGXAgent,
    "pixelnav": PixelNavAgent,
    "l3mvn": L3MVNAgent,
}


def home(observe: str = "symbolic", level: str = "retrieval") -> UcONEnv:
    return UcONEnv(episodes(1), observe=observe, detector=True, habit_level=level)  # type: ignore[arg-type]


def decisions(agent: AskingAgent, env: UcONEnv, most: int = 120) -> list[Decision]:
    """The decisions of one search, each as it was when the model was asked, in a home without the target."""
    heard: list[Decision] = []
    choose = agent.choose

    def listen(due, slots):  # type: ignore[no-untyped-def]
        heard.extend(due)
        return choose(due, slots)

    agent.choose = listen  # type: ignore[method-assign]
    play(agent, env, gone(episodes(1)[0]), most)
    assert len(heard) > 2
    return heard


def first(agent: AskingAgent, env: UcONEnv) -> Decision:
    """The first decision of an episode."""
    obs, info = env.reset(options={"episode": gone(episodes(1)[0])})
    agent.reset([info])
    explorer = agent._explorers[0]
    while (action := explorer.look(obs, info)) is not None:
        obs, _, _, _, info = env.step(int(action))
    return explorer.decision()


def test_names_of_directions_go_by_headings() -> None:
    decision = first(agent := LGXAgent(EncoderModel()), home())
    here = decision.known.view
    for candidate in decision.candidates:
        turn = (candidate.view.heading - here.heading) % 4
        assert side_of(decision.known, candidate) == SIDES[4][turn] == ("front", "left", "behind", "right")[turn]
        assert angle_of(decision.known, candidate.view.heading) == (0, 270, 180, 90)[turn]
    (question,) = agent.questions(decision, 0)
    assert [o.name for o in question.options] == [side_of(decision.known, c) for c in decision.candidates]
    assert all(f"\n{o.name}: " in f"\n{question.situation}" for o in question.options)
    assert question.target in question.situation
    assert "free for" in question.situation


def test_a_thing_means_a_direction_that_shows_it() -> None:
    agent = LGXAgent(EncoderModel(), mode="object")
    decision = first(agent, home())
    (question,) = agent.questions(decision, 0)
    names = [option.name for option in question.options]
    assert len(names) == len(set(names)) > len(decision.candidates)
    for number, name in enumerate(names):
        chosen = agent.conclude(decision, [question], [Answer(number)])
        shown = [{phrase(thing) for thing, _ in c.things} for c in decision.candidates]
        assert name in shown[chosen.number]
        assert not any(name in things for things in shown[: chosen.number])
        assert not chosen.fallback
        assert chosen.options[chosen.answered] == name
    lost = agent.conclude(decision, [question], [Answer(-1, failure="unusable")])
    assert lost.fallback
    assert lost.answered == -1
    assert 0 <= lost.number < len(decision.candidates)


@pytest.mark.parametrize("name", MAKERS)
def test_options_can_be_listed_in_any_order(name: str) -> None:
    """The same lines and names in another order, and nothing else."""
    decision = first(agent := MAKERS[name](EncoderModel()), home())
    question = agent.questions(decision, 0)[0]
    names = [option.name for option in question.options]
    assert question.listed is not None
    assert question.listed(range(len(names))) == question.situation
    told = question.listed(range(len(names))[::-1])
    assert told != question.situation
    assert f": {', '.join(reversed(names))}." in told
    split = [sorted(text.replace("\n", ", ").replace(": ", ", ").split(", ")) for text in (told, question.situation)]
    ends = [[word.strip(".") for word in words] for words in split]
    assert sorted(ends[0]) == sorted(ends[1])
    if name in ("lgx", "lgx_warm", "pixelnav"):  # also the lines of the views
        lines = [line for line in told.split("\n") if line.partition(":")[0] in names]
        assert [line.partition(":")[0] for line in lines] == names[::-1]


def test_directions_in_which_nothing_is_seen_can_be_chosen() -> None:
    decision = first(agent := LGXAgent(EncoderModel()), home())
    decision = replace(decision, candidates=tuple(replace(one, things=()) for one in decision.candidates))
    (question,) = agent.questions(decision, 0)
    assert len(question.options) == len(decision.candidates) > 1
    assert all(f"{option.name}: " in question.situation for option in question.options)


def test_what_it_is_asked_with_is_told_in_the_fingerprint(tmp_path: Path) -> None:
    own = tmp_path / "own.txt"
    own.write_text((PROMPTS / "lgx.txt").read_text())
    shipped, same = LGXAgent(EncoderModel()), LGXAgent(EncoderModel(), prompt=str(own))
    own.write_text(own.read_text().replace("[situation]", "Be quick.\n[situation]"))
    other = LGXAgent(EncoderModel(), prompt=str(own))
    assert shipped.fingerprint() == same.fingerprint() != other.fingerprint()
    folder = save_causal(tmp_path / "llama", positions=2048)
    asked, without = LGXAgent(CausalModel(str(folder))), LGXAgent(CausalModel(str(tmp_path / "nothing")))
    assert asked.fingerprint() not in (None, shipped.fingerprint())
    assert without.fingerprint() is None


def test_answers_are_drawn_by_their_scores_and_the_seed() -> None:
    def chosen(seed: int, temperature: float) -> list[int]:
        agent = LGXAgent(EncoderModel(), temperature=temperature, seed=seed)
        play(agent, env, gone(episodes(1)[0]), 120)
        return [d.chosen for d in agent.decisions(0)]

    env = home()
    assert chosen(0, 5.0) == chosen(0, 5.0)
    assert chosen(0, 5.0) != chosen(1, 5.0)
    agent = LGXAgent(EncoderModel(), temperature=0.5)
    answer = Answer(0, tuple(np.log([0.6, 0.3, 0.1]).tolist()))
    drawn = [agent.pick(answer, 3, np.random.default_rng(k))[0] for k in range(2000)]
    assert np.bincount(drawn) / 2000 == pytest.approx(np.array([0.36, 0.09, 0.01]) / 0.46, abs=0.03)
    with pytest.raises(ConfigError, match="temperature=-1"):
        LGXAgent(EncoderModel(), temperature=-1)


def test_memory_is_told_where_it_is_wanted() -> None:
    for memory in (True, False):
        agent = LGXAgent(EncoderModel(), memory=memory, goal="farthest")
        told = []
        conclude = agent.conclude
        agent.conclude = lambda d, q, a: (told.append((d, q[0].situation)), conclude(d, q, a))[1]  # type: ignore  # noqa: B023
        play(agent, home(), gone(episodes(1)[0]), 250)
        assert ("you have been there" in "".join(text for _, text in told)) == memory


def test_the_picture_of_four_views() -> None:
    agent = PixelNavAgent(SeeingEncoder(), inputs="images")
    decision = first(agent, home("pixels"))
    kept = [s.rgb.copy() for s in decision.sightings if s.rgb is not None]
    picture = mosaic(decision)
    assert picture.shape == (2 * 128 + 10, 2 * 128 + 10, 3)
    assert (picture[128:138] == 255).all()
    assert (picture[:, 128:138] == 255).all()
    for sighting, rgb in zip(decision.sightings, kept, strict=True):
        angle = angle_of(decision.known, sighting.view.heading)
        y, x = {0: (0, 0), 90: (0, 138), 180: (138, 0), 270: (138, 138)}[angle]
        tile = picture[y : y + 128, x : x + 128]
        assert (tile[40:] == rgb[40:]).all()
        assert (tile[:40] != rgb[:40]).any()  # the angle is written there
        assert (sighting.rgb == rgb).all()  # it is written on a copy
    (question,) = agent.questions(decision, 0)
    assert (question.images[0] == picture).all()
    assert agent.name == "pixelnav_images"


def test_a_camera_is_needed_for_pictures() -> None:
    with pytest.raises(ConfigError, match=r"needs images: set env\.observe=pixels") as caught:
        play(PixelNavAgent(SeeingEncoder(), inputs="images"), home(), episodes(1)[0])
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda m: LGXAgent(m, mode="objects"), "unknown mode of agent lgx 'objects': did you mean object"),
        (lambda m: LGXAgent(m, goal="far"), "unknown goal of agent lgx 'far'"),
        (lambda m: PixelNavAgent(m, inputs="image"), "unknown inputs of agent pixelnav 'image': did you mean images"),
        (
            lambda m: PixelNavAgent(m, inputs="images"),
            r"encoder \(all-MiniLM-L6-v2\) sees none; choose language=vision_lm",
        ),
        (lambda m: PixelNavAgent(CausalModel("tiny"), inputs="images"), r"causal \(tiny\) sees none"),
        (lambda m: L3MVNAgent(ChatModel(ChatClient("http://127.0.0.1:9/v1", "tiny"))), r"chat \(tiny\) gives none"),
    ],
)
def test_what_cannot_work_is_refused_in_one_line(make, message: str) -> None:  # type: ignore[no-untyped-def]
    with pytest.raises(ConfigError, match=message) as caught:
        make(EncoderModel())
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("scores", "number"),
    [
        ([0.2, 0.5, 0.4], 1),  # a sure one
        ([0.2, 0.3, 0.25], 0),  # none is above 0.3: the first possible one
        ([0.05, 0.1, 0.15], 2),
        ([0.05, 0.1, 0.01], 0),  # none is possible: the most useful
        ([0.4, 0.4], 0),
    ],
)
def test_the_rule_of_l3mvn(scores: list[float], number: int) -> None:
    assert select(scores, 0.3, 0.1) == number


def test_frontiers_are_few_and_rated() -> None:
    agent, described = L3MVNAgent(EncoderModel()), 0
    heard = decisions(agent, home(), 300)
    made = agent.decisions(0)
    for decision, record in zip(heard, made, strict=True):
        utility = [c.utility for c in decision.candidates]
        assert len(decision.candidates) <= 4
        assert utility == sorted(utility, reverse=True)
        assert record.asked == (sum(bool(c.things) for c in decision.candidates) if len(utility) > 1 else 0)
        for candidate, score in zip(decision.candidates, record.scores, strict=False):
            described += bool(candidate.things)
            assert candidate.things or 0.1 < score <= 0.2
        if record.asked:
            assert record.chosen == select(record.scores, 0.3, 0.1)
    assert described > 3


def test_without_an_answer_frontiers_go_by_utility() -> None:
    agent = L3MVNAgent(EncoderModel())
    decision = first(agent, home())
    one = decision.candidates[0]
    there = tuple(replace(one, utility=u, things=things) for u, things in ((20.0, (("sofa", 1),)), (10.0, ())))
    decision = replace(decision, candidates=there)
    questions = agent.questions(decision, 0)
    assert len(questions) == 1
    assert questions[0].things == ("sofa",)
    lost = agent.conclude(decision, questions, [Answer(-1, failure="unusable")])
    assert (lost.number, lost.fallback, lost.scores) == (0, True, (0.2, 0.15))
    n = len(questions[0].options)
    sure = tuple(np.log([0.9, *[0.1 / (n - 1)] * (n - 1)]).tolist())
    found = agent.conclude(decision, questions, [Answer(0, sure)])
    assert found.scores[0] == pytest.approx(0.9 * n / LABELS_THERE, abs=1e-3)
    assert not found.fallback


def test_labels_are_the_target_and_others_once() -> None:
    book = catalogue()
    for target in [name for name in book.names if book[name].role == "movable"][::25]:
        labels = label_set(target, 20)
        assert labels[0] == phrase(target)
        assert len(labels) == len(set(labels)) == 20
        assert labels == label_set(target, 20)
        assert all(book[label.replace(" ", "_")].role == "movable" for label in labels[1:])
    assert label_set("mug", 1) == ("mug",)
    assert len(label_set("mug", 10**6)) == len(set(label_set("mug", 10**6)))
    a, b = (first(L3MVNAgent(EncoderModel()), home(level=level)).target for level in ("none", "full"))
    assert label_set(a, 20) == label_set(b, 20)


@pytest.mark.parametrize("name", MAKERS)
def test_a_chat_model_on_this_machine_plays(name: str, tmp_path_factory: pytest.TempPathFactory) -> None:
    """A tiny random model: its answers mean nothing, but each is one of the options and repeatable."""
    folder = save_causal(tmp_path_factory.mktemp("tiny") / "llama", positions=2048)
    runs = []
    for _ in range(2):
        agent = MAKERS[name](CausalModel(str(folder), device="cpu", dtype="float32"))
        play(agent, home(level="gt"), episodes(1)[0], 40)
        runs.append([d.to_line() for d in agent.decisions(0)])
        asked = [d for d in agent.decisions(0) if d.asked]
        assert asked
        assert all(d.prompt_tokens > 0 and not d.fallback and d.scores for d in asked)
    assert runs[0] == runs[1]


@pytest.mark.parametrize("path", sorted(PROMPTS.glob("*.txt")), ids=lambda path: path.stem)
def test_every_prompt_has_the_slots_that_are_filled(path: Path) -> None:
    prompt = Prompt.load(path)
    assert prompt.slots("system") <= {"target", "habits"}
    assert "habits" in prompt.slots("system")
    assert prompt.slots("situation") <= {"target", "views", "things", "options"}
    assert "options" in prompt.slots("situation")
    if "cloze" in prompt.parts:
        assert prompt.slots("cloze") <= {"target", "things"}
        assert prompt.cloze(**dict.fromkeys(prompt.slots("cloze"), "{sofa}")).count("{}") == 1
    filled = prompt.system(**{slot: "" if slot == "habits" else "mug" for slot in prompt.slots("system")})
    assert "{" not in filled + prompt.situation(**dict.fromkeys(prompt.slots("situation"), "x"))


def test_things_are_told_as_prose() -> None:
    assert listed([("sofa", 1), ("armchair", 3), ("coffee_table", 1)]) == "sofa, 3 x armchair, coffee table"
    assert listed([]) == "nothing"
    assert listed([("sofa", 1)] * 30, 2) == "sofa, sofa"


def test_a_prompt_of_ones_own(tmp_path: Path) -> None:
    own = tmp_path / "own.txt"
    own.write_text("Mine.\n[system]\nFind {target}.\n{habits}\n[situation]\nWhere? {options}\n")
    decision = first(agent := LGXAgent(EncoderModel(), prompt=str(own)), home(level="none"))
    (question,) = agent.questions(decision, 0)
    assert question.system == f"Find {question.target}."
    assert question.situation.startswith("Where? front")
