"""Fine-tuning of the retriever on a small random encoder, and what it may learn from."""

import json

import numpy as np
import pytest
import torch
from safetensors.torch import save

from tests.learning.tiny import some_habits, tiny_learner, write_tiny_bert
from ucon.core.errors import ConfigError, DataError, DivergedError
from ucon.core.files import write_manifest
from ucon.habits import book
from ucon.habits.splits import entry_parts
from ucon.language import MiniLM
from ucon.language.adapted import AdaptedMiniLM
from ucon.language.adapter import adapter_bytes, add_adapters, merge, read_adapter
from ucon.language.encoder import MINILM_SHA256
from ucon.learning.retriever.learner import PRODUCT, RetrieverLearner, info_nce, owner_loss, schedule
from ucon.learning.run.protocol import State
from ucon.learning.run.stopping import Stopping
from ucon.learning.run.training_run import METRICS, Plan, TrainingRun
from ucon.readers.sampled_homes import part_kb

TEXTS = ["The keys hang by the door.", "tea", "Every night the wallet is left on the low table."]


@pytest.fixture(scope="module")
def bert(tmp_path_factory):
    return write_tiny_bert(tmp_path_factory.mktemp("bert"))


def learned(folder):
    run = folder / "checkpoints"
    return (run / (run / "latest").read_text().strip() / "tensors.safetensors").read_bytes()


def test_loss_falls(bert):
    learner = tiny_learner(bert, steps=30)
    losses = [learner.step()["loss"] for _ in range(12)]
    assert np.mean(losses[-4:]) < np.mean(losses[:4]) - 0.05


def test_a_resumed_run_is_bit_identical(bert, tmp_path):
    plan = Plan(steps=6, validate_every=3, save_every=2)
    whole = TrainingRun(tmp_path / "whole", tiny_learner(bert), plan, {})
    whole.start("")
    whole.run()
    parts = TrainingRun(tmp_path / "parts", tiny_learner(bert), plan, {})
    parts.start("")
    parts._begin(Stopping(print), lambda step, figures: None)
    for _ in range(4):
        parts._one_step(Stopping(print), lambda step, figures: None)
    again = TrainingRun(tmp_path / "parts", tiny_learner(bert), plan, {})
    again.resume()
    assert again.step == 4
    again.run()
    for name in (METRICS, f"model/{PRODUCT}"):
        assert (tmp_path / "whole" / name).read_bytes() == (tmp_path / "parts" / name).read_bytes()
    assert learned(tmp_path / "whole") == learned(tmp_path / "parts")
    assert whole.learner.state_dict().tensors.keys() == again.learner.state_dict().tensors.keys()


def test_the_average_is_what_is_kept(bert):
    learner = tiny_learner(bert, average=0.5)
    before = {name: value.clone() for name, value in learner.updates.average.items()}
    seen = []
    for _ in range(3):
        learner.step()
        seen.append({name: value.detach().clone() for name, value in learner.updates.parameters.items()})
    for name, start in before.items():
        wanted = start
        for k, values in enumerate(seen):
            wanted = wanted.lerp(values[name], 1 - min(0.5, (1 + k) / (10 + k)))
        assert torch.allclose(learner.updates.average[name], wanted)
    learner.validate()
    assert all(torch.equal(value, seen[-1][name]) for name, value in learner.updates.parameters.items()), "put back"
    assert learner.product()[PRODUCT] == adapter_bytes(learner.updates.average, MINILM_SHA256)
    follows = tiny_learner(bert, average=0.0)
    follows.step()
    assert all(torch.equal(value, follows.updates.average[name]) for name, value in follows.updates.parameters.items())


def test_masking_hides_tokens_but_never_the_marks_around_them(bert):
    encode = tiny_learner(bert)._encode
    ids = encode._tokenizer(TEXTS * 30)["input_ids"]
    hidden = encode._masked(ids, 0.3, np.random.default_rng(0))
    mask = encode._tokenizer.mask_token_id
    inner = [(a, b) for x, y in zip(ids, hidden, strict=True) for a, b in zip(x[1:-1], y[1:-1], strict=True)]
    assert all(b in (a, mask) for a, b in inner)
    assert 0.25 < np.mean([b == mask for _, b in inner]) < 0.35
    assert all((x[0], x[-1]) == (y[0], y[-1]) for x, y in zip(ids, hidden, strict=True))
    with torch.no_grad():
        plain, one, same, other = (encode(TEXTS, *how) for how in ((), (0.3, 1), (0.3, 1), (0.3, 2)))
    assert torch.equal(one, same)
    assert not torch.equal(one, plain)
    assert not torch.equal(one, other)


@pytest.mark.parametrize("option", [{"mask": 1.0}, {"average": 1.0}, {"mask": -0.1}])
def test_shares_outside_their_range_are_refused(bert, option):
    with pytest.raises(ConfigError, match="at least 0 and below 1"):
        tiny_learner(bert, **option)


@pytest.mark.parametrize(
    ("option", "message"),
    [
        ({"rank": "abc"}, r"learner\.rank=abc: must be above 0 and whole"),
        ({"steps": 1.5}, r"learner\.steps=1\.5: must be above 0 and whole"),
        ({"n_kbs": True}, r"learner\.n_kbs=True: must be above 0 and whole"),
        ({"warm_up": None}, r"learner\.warm_up=None"),
        ({"seed": "abc"}, r"learner\.seed=abc: must be a whole number"),
        ({"lr": "fast"}, r"learner\.lr=fast: must be above 0"),
        ({"temperature": float("nan")}, r"learner\.temperature=nan: must be above 0"),
        ({"other_weight": float("inf")}, r"learner\.other_weight=inf: must be above 0"),
        ({"decay": -1}, r"learner\.decay=-1: must be at least 0"),
        ({"owner": -5}, r"learner\.owner=-5: must be at least 0"),
        ({"mask": "half"}, r"learner\.mask=half: must be at least 0 and below 1"),
        ({"precision": ["bfloat16"]}, "unknown precision"),
    ],
)
def test_options_of_the_wrong_kind_are_refused(bert, option, message):
    with pytest.raises(ConfigError, match=message):
        tiny_learner(bert, **option)


def test_numbers_that_are_none_stop_it_by_name(bert):
    learner = tiny_learner(bert)
    with torch.no_grad():
        next(iter(learner.updates.parameters.values())).fill_(float("nan"))
    with pytest.raises(DivergedError, match=r"step 1: gradient of \S+ is not finite"):
        learner.step()


def test_state_of_another_learner_is_refused(bert):
    state = tiny_learner(bert, rank=3).state_dict()
    with pytest.raises(DataError, match="names or shapes differ"):
        tiny_learner(bert).load_state_dict(state)
    stepped = tiny_learner(bert)
    stepped.step()
    with pytest.raises(DataError, match="names or shapes differ"):
        tiny_learner(bert).load_state_dict(State(stepped.state_dict().tensors, {"done": 0}))


def test_only_training_entries_teach(bert):
    """With the whole book, hundreds of steps never read a sentence of a val or test entry."""
    learner = tiny_learner(bert)
    learner.dataset = book()
    parts = entry_parts(book())
    held = {h.text for e in book().entries if parts[e.id] != "train" for h in e.habits}
    read = set()
    for step in range(300):
        kb = learner.training_kb(step)
        assert {parts[e.id] for entries in kb.entries.values() for e in entries} == {"train"}
        read |= set(kb.texts)
    shared = read & held
    assert len(read) > 3000
    assert not shared, sorted(shared)[:3]
    chosen = {parts[e.id] for kb in learner.validation_kbs for entries in kb.entries.values() for e in entries}
    assert chosen == {"val"}


def test_knowledge_bases_of_a_part():
    kb = part_kb(some_habits(), "train", 1)
    assert all(len(entries) == 1 for entries in kb.entries.values())
    assert len(kb.entries) == 20
    assert list(kb.rows) == list(part_kb(some_habits(), "train", 1).rows)
    assert set(kb.rows) != set(part_kb(some_habits(), "train", 2).rows)


def test_a_new_adapter_changes_nothing(tmp_path):
    _, model = MiniLM().parts()
    path = tmp_path / PRODUCT
    path.write_bytes(adapter_bytes(add_adapters(model, 4, seed=0), MINILM_SHA256))
    write_manifest(tmp_path, [PRODUCT])
    adapted = AdaptedMiniLM(path)
    assert adapted.encode(TEXTS).tobytes() == MiniLM().encode(TEXTS).tobytes()
    assert adapted.name.startswith(MiniLM().name + "+")


def test_merged_is_what_was_trained(bert):
    learner = tiny_learner(bert)
    for _ in range(2):
        learner.step()
    with torch.no_grad():
        trained = learner._encode(TEXTS)
    _, plain = (encoder := MiniLM(bert, check=False)).parts()
    merge(plain, {name: value.detach() for name, value in learner.updates.parameters.items()})
    inputs = encoder.parts()[0](TEXTS[0], return_tensors="pt")
    with torch.no_grad():
        alone = torch.nn.functional.normalize(plain(**inputs).last_hidden_state[0].mean(0), dim=0)
    assert torch.allclose(alone, trained[0], atol=1e-5)


def test_unfit_adapters_are_refused(bert, tmp_path):
    path = tmp_path / PRODUCT
    path.write_bytes(tiny_learner(bert).product()[PRODUCT])
    with pytest.raises(DataError, match="cannot be verified"):
        read_adapter(path, MINILM_SHA256)
    write_manifest(tmp_path, [PRODUCT])
    with pytest.raises(DataError, match="made for weights"):
        read_adapter(path, "0" * 64)
    with pytest.raises(DataError, match="use the encoder it was made for"):
        AdaptedMiniLM(path).encode(["x"])
    adapter = read_adapter(path, MINILM_SHA256)
    first = next(iter(adapter))
    _, plain = MiniLM(bert, check=False).parts()
    with pytest.raises(DataError, match="does not fit"):
        merge(plain, adapter | {first: adapter[first][:, :-1]})
    path.write_bytes(b"x" * 50)
    with pytest.raises(DataError, match="truncated or altered"):
        read_adapter(path, MINILM_SHA256)
    write_manifest(tmp_path, [PRODUCT])
    with pytest.raises(DataError, match="not an adapter"):
        read_adapter(path, MINILM_SHA256)


def test_it_may_begin_with_another_adapter(bert, tmp_path):
    taught = tiny_learner(bert)
    for _ in range(3):
        taught.step()
    run = tmp_path / "run"
    (run / "model").mkdir(parents=True)
    (run / "model" / PRODUCT).write_bytes(taught.product()[PRODUCT])
    write_manifest(run / "model", [PRODUCT])
    for initial in (run, run / "model", run / "model" / PRODUCT):
        again = tiny_learner(bert, initial=str(initial), seed=7)
        for name, value in again.updates.parameters.items():
            assert torch.allclose(value, taught.updates.average[name], atol=1e-3), name
            assert torch.equal(again.updates.average[name], value)
        assert again.identity.keys() - tiny_learner(bert).identity.keys() == {"initial"}
    with pytest.raises(DataError, match=r"expected \(3, .*; give its own learner.rank"):
        tiny_learner(bert, initial=str(run), rank=3)
    with pytest.raises(DataError, match="no adapter there"):
        tiny_learner(bert, initial=str(tmp_path))


def test_adapters_that_are_no_numbers_or_no_matrices_leave_the_encoder_as_it_was(bert, tmp_path):
    right = tiny_learner(bert).updates.average
    first = next(iter(right))
    path = tmp_path / PRODUCT
    for value, message in ((right[first] * torch.nan, "not finite"), (right[first].to(torch.int64), "of int64")):
        path.write_bytes(save(dict(right) | {first: value}, {"base_sha256": MINILM_SHA256}))
        write_manifest(tmp_path, [PRODUCT])
        with pytest.raises(DataError, match=f"not an adapter: .*{message}"):
            read_adapter(path, MINILM_SHA256)
    _, plain = MiniLM(bert, check=False).parts()
    before = {name: value.clone() for name, value in plain.state_dict().items()}
    last = list(right)[-1]
    for odd in (right[last][0], right[last][None], right[last][:, :0]):
        with pytest.raises(DataError, match="does not fit"):
            merge(plain, {name: value + 1 for name, value in right.items()} | {last: odd})
    assert all(torch.equal(before[name], value) for name, value in plain.state_dict().items())


def test_info_nce_by_hand():
    similarity = torch.tensor([[0.9, 0.5, 0.1]])
    own = torch.tensor([[True, True, False]])
    one, two = (torch.log1p(torch.exp(torch.tensor((0.1 - s) / 0.1))) for s in (0.9, 0.5))
    loss = info_nce(similarity, own, torch.tensor([1.0, 0.5, 1.0]), 0.1)
    assert float(loss) == pytest.approx(float((one + 0.5 * two) / 1.5), rel=1e-5)


def test_owner_loss_by_hand():
    similarity = torch.tensor([[0.9, 0.5], [0.1, 0.7]])
    own = torch.tensor([[True, False], [False, True]])
    one, two = (torch.log1p(torch.exp(torch.tensor(d / 0.1))) for d in (0.1 - 0.9, 0.5 - 0.7))
    loss = owner_loss(similarity, own, torch.tensor([1.0, 0.5]), 0.1)
    assert float(loss) == pytest.approx(float((one + 0.5 * two) / 1.5), rel=1e-5)


def test_schedule():
    rates = [schedule(step, 100, 10) for step in range(100)]
    assert rates[0] == pytest.approx(0.1)
    assert max(rates) == rates[9] == rates[10] == 1
    assert rates[10:] == sorted(rates[10:], reverse=True)
    assert rates[-1] < 0.001


def test_card_and_bad_options(bert):
    card = tiny_learner(bert).card()
    assert "`test` entries were not read" in card.text
    json.dumps(dict(tiny_learner(bert).identity))
    with pytest.raises(ConfigError, match="unknown precision 'float16'"):
        RetrieverLearner(some_habits(), steps=1, precision="float16")
    with pytest.raises(ConfigError, match=r"learner\.dataset=book: .* habits="):
        RetrieverLearner("book", steps=1)
    with pytest.raises(ConfigError, match="must be above 0"):
        RetrieverLearner(some_habits(), steps=1, rank=0)
