"""Questions as chat prompts: rendered by a model's own template, cut to its window by whole habits."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, Final

from ucon.core.errors import DataError
from ucon.language.prompt import first_habits, habits_in

_PROBE: Final = ("probe of the system", "probe of the user")


class ChatTemplate:
    """Renders a system and a user message as the prompt for an answer.

    Templates differ: some take the system message as a string, some as a list of parts, and some allow none (or none
    together with images); then its text goes before the user's. The form is found once, by trying.
    """

    def __init__(self, owner: Any, where: str, options: Mapping[str, Any] | None = None) -> None:
        """Set the template; it is tried at first use.

        Args:
            owner: tokenizer or processor with ``apply_chat_template``.
            where: names the model in errors.
            options: passed to the template, such as ``{"enable_thinking": False}``.
        """
        self._owner, self._where, self._options = owner, where, dict(options or {})
        self._style: dict[bool, str] = {}

    def render(self, system: str, user: str, images: int = 0) -> str:
        """The conversation as text, up to where the answer begins.

        Args:
            system: message.
            user: message.
            images: number of placeholders before the user's text.

        Raises:
            DataError: the model has no chat template, or one that cannot render this.
        """
        seen = images > 0
        if seen not in self._style:
            self._style[seen] = self._tried(images)
        return self._rendered(self._style[seen], system, user, images)

    def _tried(self, images: int) -> str:
        error = "it drops a part of its input"
        if not getattr(self._owner, "chat_template", None):
            raise DataError(f"{self._where}: no chat template; choose an instruction-tuned model")
        for style in ("text", "parts", "folded"):
            try:
                found = self._rendered(style, *_PROBE, images)
            except Exception as problem:  # templates are programs and can fail in any way
                error = " ".join(str(problem).split())[:160]
                continue
            if all(probe in found for probe in _PROBE):
                return style
        raise DataError(f"{self._where}: its chat template cannot be used ({error}); choose an instruction-tuned model")

    def _rendered(self, style: str, system: str, user: str, images: int) -> str:
        if style == "folded":
            user = f"{system}\n\n{user}"
        content: Any = user
        if images or style == "parts":
            content = [*({"type": "image"} for _ in range(images)), {"type": "text", "text": user}]
        messages: list[dict[str, Any]] = [{"role": "user", "content": content}]
        if style != "folded":
            told = [{"type": "text", "text": system}] if style == "parts" else system
            messages.insert(0, {"role": "system", "content": told})
        return str(
            self._owner.apply_chat_template(messages, tokenize=False, add_generation_prompt=True, **self._options)
        )


def most_habits(system: str, fits: Callable[[str], bool], likely: int = 0) -> tuple[str, int] | None:
    """Cut the habits of a system message to the largest number that fits.

    Args:
        system: message with a habit block.
        fits: whether a system message fits into the window; where a number of habits fits, fewer do too.
        likely: habits that were dropped last time. The result does not depend on it, but takes only two trials if the
            number is the same again.

    Returns:
        The message, and how many habits were dropped at its end; None if it does not fit without habits either.
    """
    n = habits_in(system)
    if 0 < likely <= n:
        cut, longer = (first_habits(system, n - left_out) for left_out in (likely, likely - 1))
        if fits(cut) and not fits(longer):
            return cut, likely
    if fits(system):
        return system, 0
    low, high = 0, n - 1
    if n == 0 or not fits(first_habits(system, 0)):
        return None
    while low < high:
        middle = (low + high + 1) // 2
        low, high = (middle, high) if fits(first_habits(system, middle)) else (low, middle - 1)
    return first_habits(system, low), n - low


def end_tokens(model: Any, tokenizer: Any) -> list[int]:
    """Tokens that end an answer: those of the generation settings and the tokenizer's own.

    Raises:
        DataError: there is none.
    """
    said = getattr(getattr(model, "generation_config", None), "eos_token_id", None)
    found = [said] if isinstance(said, int) else list(said or ())
    if tokenizer.eos_token_id is not None:
        found.append(tokenizer.eos_token_id)
    if not found:
        raise DataError(f"{tokenizer.name_or_path}: no end-of-text token; add eos_token to the tokenizer")
    return sorted(set(found))


def window_of(model: Any) -> int:
    """Longest input of a model in tokens, by its configuration; practically unlimited if that gives none."""
    config = model.config.get_text_config()
    found = getattr(config, "max_position_embeddings", None)
    return int(found) if found else 1 << 30


def common_prefix(a: Sequence[int], b: Sequence[int]) -> int:
    """Length of the common beginning of two sequences."""
    return next((i for i, (x, y) in enumerate(zip(a, b, strict=False)) if x != y), min(len(a), len(b)))
