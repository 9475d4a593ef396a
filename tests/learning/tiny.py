"""Small real things to train: a random BERT of MiniLM's architecture, a part of the habit book, a line."""

import shutil
from functools import cache

import torch

from ucon.habits import book
from ucon.habits.types import HabitDataset
from ucon.language import MiniLM
from ucon.language.encoder import minilm_folder
from ucon.learning.retriever.learner import RetrieverLearner
from ucon.learning.run.protocol import Card, State


@cache
def some_habits(step: int = 12) -> HabitDataset:
    """Every ``step``-th category of the book."""
    names = set(book().categories[::step])
    return HabitDataset("some", tuple(e for e in book().entries if e.category in names))


def write_tiny_bert(folder, layers=2, width=24):
    """Write a model with random weights and the real tokenizer to ``folder``."""
    from transformers import BertConfig, BertModel

    torch.manual_seed(0)
    config = BertConfig(hidden_size=width, num_hidden_layers=layers, num_attention_heads=2, intermediate_size=32)
    BertModel(config).save_pretrained(folder)
    for name in ("tokenizer.json", "tokenizer_config.json", "vocab.txt", "special_tokens_map.json"):
        shutil.copy(minilm_folder() / name, folder / name)
    return folder


def tiny_learner(folder, **options) -> RetrieverLearner:
    encoder = MiniLM(folder, check=False)
    standard = {"steps": 6, "rank": 2, "lr": 1e-2, "warm_up": 2, "n_kbs": 1, "precision": "float32"}
    return RetrieverLearner(some_habits(), encoder=encoder, **{**standard, **options})


class Line:
    """The smallest learner: fits a line by gradient descent with momentum; batches depend only on the step."""

    def __init__(self, data: str = "a") -> None:
        self.weight, self.speed, self.done = torch.zeros(2), torch.zeros(2), 0
        self.identity = {"data": data}
        self.on_step = lambda done: None

    def step(self):
        x = torch.randn(8, generator=torch.Generator().manual_seed(self.done))
        error = self.weight[0] * x + self.weight[1] - (3 * x - 1)
        self.speed = 0.9 * self.speed - 0.05 * torch.stack([(error * x).mean(), error.mean()])
        self.weight = self.weight + self.speed
        self.done += 1
        self.on_step(self.done)
        return {"loss": float((error**2).mean())}

    def validate(self):
        return {"score": -float((self.weight - torch.tensor([3.0, -1.0])).abs().sum())}

    def state_dict(self):
        return State({"weight": self.weight, "speed": self.speed}, {"done": self.done})

    def load_state_dict(self, state):
        self.weight, self.speed = state.tensors["weight"], state.tensors["speed"]
        self.done = state.values["done"]

    def lengthen(self, steps):
        self.length = steps
        return False

    def product(self):
        return {"line.bin": self.weight.numpy().tobytes()}

    def card(self):
        return Card("A line", "Fitted to points.")

    def close(self):
        pass
