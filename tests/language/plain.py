"""Scores of a causal model by whole forward passes, one per option, without cache or batches."""

import numpy as np
import torch
import transformers

from ucon.language.choice import Question


class PlainPasses:
    """Log-probabilities of answers, summed over tokens."""

    def __init__(self, folder: str) -> None:
        self._tokenizer = transformers.AutoTokenizer.from_pretrained(folder)
        self._network = transformers.AutoModelForCausalLM.from_pretrained(folder).eval()

    def __call__(self, asked: Question):
        """Log-probabilities of the options (n,), their numbers of tokens (n,), and that of the prompt."""
        messages = [{"role": "system", "content": asked.system}, {"role": "user", "content": asked.situation}]
        text = self._tokenizer.apply_chat_template(messages, tokenize=False, add_generation_prompt=True)
        prompt = self._tokenizer(text, add_special_tokens=False)["input_ids"]
        totals, lengths = [], []
        for option in asked.options:
            own = self._tokenizer(option.name, add_special_tokens=False)["input_ids"]
            with torch.no_grad():
                said = self._network(torch.tensor([prompt + own])).logits[0].log_softmax(-1)
            total = sum(float(said[len(prompt) - 1 + i, token]) for i, token in enumerate(own))
            ends = said[-1].exp()[[1, 5]].sum().log()  # </s> and <|end|>
            totals.append(total + float(ends))
            lengths.append(len(own) + 1)
        return np.array(totals), np.array(lengths), len(prompt)


def normal(x):
    return x - np.logaddexp.reduce(x)
