"""``chat_api``: any model behind an OpenAI-compatible server, asked to name one of the options.

Whatever the server does, a question ends within ``timeout_s x (retries + 1)`` seconds, with one of the options or with
none and the reason. Only a key that is missing or refused from the start is an error.
"""

from __future__ import annotations

import base64
import io
import time
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any, Final

from ucon.core.errors import AnswerError, ConfigError, ServerError
from ucon.language.choice import Answer, Image, Question
from ucon.language.match import chosen
from ucon.language.servers.chat import ChatClient, Message
from ucon.language.servers.chat_request import AskLimits

_TEXT: Final = 500
_REFUSED: Final = (401, 403)


class ChatModel:
    """Asks a server; the client keeps answers on disk."""

    gives_scores = False
    sees_images = True

    def __init__(self, client: ChatClient, *, retries: int = 3, parallel: int = 4) -> None:
        """Set the client; nothing is sent yet.

        Args:
            client: server, model, timeout and sampling; its own number of attempts is not used.
            retries: further requests after a fault or an unusable answer, each with another seed.
            parallel: questions of a batch that are asked at the same time.

        Raises:
            ConfigError: a number out of range.
        """
        if retries < 0 or parallel < 1:
            raise ConfigError(f"retries={retries}, parallel={parallel}: expected at least 0 and 1")
        self._client, self._retries, self._parallel = client, retries, parallel
        self._served = False

    @property
    def name(self) -> str:
        """Such as ``chat (llama3.1:8b)``."""
        return f"chat ({self._client.model})"

    def check(self) -> None:
        """Send one small request; see :meth:`ucon.language.choice.LanguageModel.check`."""
        self._client.check()

    def answer(self, questions: Sequence[Question]) -> list[Answer]:
        """Answer questions; see :meth:`ucon.language.choice.LanguageModel.answer`.

        Raises:
            ConfigError: the key is missing, or refused before anything was answered.
        """
        if len(questions) < 2 or self._parallel == 1:
            return [self._answer(question) for question in questions]
        with ThreadPoolExecutor(min(self._parallel, len(questions))) as pool:
            return list(pool.map(self._answer, questions))

    def _answer(self, question: Question) -> Answer:
        start = time.perf_counter()
        names = [option.name for option in question.options]
        limits = AskLimits(self._retries + 1, self._client.timeout_s * (self._retries + 1))
        try:
            reply = self._client.ask(
                messages_of(question),
                schema=schema_of(names),
                usable=lambda text: chosen(text, names) >= 0,
                limits=limits,
            )
        except ServerError as error:
            if error.status in _REFUSED and not self._served:
                raise self._client.refused(error.status) from None
            return Answer(
                -1,
                retries=error.attempts - 1,
                prompt_tokens=error.prompt_tokens,
                completion_tokens=error.completion_tokens,
                seconds=time.perf_counter() - start,
                failure="unusable" if isinstance(error, AnswerError) else "server",
            )
        self._served = True
        choice = chosen(reply.text, names)
        return Answer(
            choice,
            places=(choice,),
            text=reply.text[:_TEXT],
            retries=max(reply.attempts - 1, 0),
            prompt_tokens=reply.prompt_tokens,
            completion_tokens=reply.completion_tokens,
            seconds=reply.seconds,
        )


def messages_of(question: Question) -> list[Message]:
    """A question as messages: system, and the user's text after the images.

    The form of the answer is described in words too, since some servers ignore the schema silently.
    """
    names = ", ".join(f'"{option.name}"' for option in question.options)
    form = f'Answer with one JSON object: {{"reason": a few words, "choice": one of {names}}}.'
    text = f"{question.situation}\n\n{form}"
    content: Any = text
    if question.images:
        seen = [{"type": "image_url", "image_url": {"url": data_url(image)}} for image in question.images]
        content = [*seen, {"type": "text", "text": text}]
    return [{"role": "system", "content": question.system}, {"role": "user", "content": content}]


def schema_of(names: Sequence[str]) -> dict[str, Any]:
    """JSON schema of an answer: a reason and one of the names."""
    return {
        "type": "object",
        "properties": {"reason": {"type": "string"}, "choice": {"type": "string", "enum": list(names)}},
        "required": ["reason", "choice"],
        "additionalProperties": False,
    }


def data_url(image: Image) -> str:
    """An image (H, W, 3) uint8 as a data URL with a PNG."""
    from PIL import Image as Picture

    buffer = io.BytesIO()
    Picture.fromarray(image).save(buffer, "PNG")
    return f"data:image/png;base64,{base64.b64encode(buffer.getvalue()).decode()}"
