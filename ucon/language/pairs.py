"""Features of (habit, candidate) pairs: is this sentence about that category?

Readers hardly learn from frozen sentence embeddings alone; these features make the difference. They depend on the two
texts only, so a new category gets its column when it is first seen.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache, lru_cache

import numpy as np
from numpy.typing import NDArray

from ucon.core.files import read_verified
from ucon.core.untrusted.unpack import MAX_BYTES, read_arrays
from ucon.language.lexicon import LEXICAL, Lexicon, catalogue_lexicon
from ucon.language.quantise import Quantised, cosines, quantise
from ucon.language.store import DATA, StoredEncoder, default_encoder
from ucon.language.words import STOP_WORDS, tokens

#: Columns of :meth:`PairReader.features`.
FEATURES = (*LEXICAL, "word", "sentence")
N_FEATURES = len(FEATURES)


class WordVectors:
    """Vectors of single words. The book's vocabulary is shipped; other words are encoded when first met."""

    def __init__(self, words: Sequence[str], vectors: Quantised, encoder: StoredEncoder) -> None:
        """Start with n words.

        Args:
            words: the words.
            vectors: their n vectors.
            encoder: encodes further words.
        """
        self._row = {word: i for i, word in enumerate(words)}
        self._codes = vectors.codes
        self._scale = vectors.scale
        self._encoder = encoder

    @classmethod
    def load(cls, encoder: StoredEncoder) -> WordVectors:
        """The shipped words.

        Raises:
            DataError: the file is missing or altered.
        """
        file = read_arrays(read_verified(DATA / "words.npz"), MAX_BYTES)
        words = file["words"].tobytes().decode().split("\n")
        return cls(words, Quantised(file["codes"], file["scale"]), encoder)

    def rows(self, words: Sequence[str]) -> NDArray[np.int64]:
        """Row numbers (n,) int64 of n words; new words are encoded and added."""
        new = [word for word in dict.fromkeys(words) if word not in self._row]
        if new:
            added = quantise(self._encoder.encode_half(new))
            self._row.update((word, len(self._codes) + i) for i, word in enumerate(new))
            self._codes = np.concatenate([self._codes, added.codes])
            self._scale = np.concatenate([self._scale, added.scale])
        return np.fromiter((self._row[word] for word in words), np.int64, len(words))

    def take(self, rows: NDArray[np.int64]) -> Quantised:
        """Vectors of some rows."""
        return Quantised(self._codes[rows], self._scale[rows])

    def __len__(self) -> int:
        return len(self._codes)


class PairReader:
    """Computes pair features."""

    def __init__(self, encoder: StoredEncoder, words: WordVectors, lexicon: Lexicon) -> None:
        """Set the tables.

        Args:
            encoder: of sentences.
            words: vectors of single words.
            lexicon: finds names in sentences.
        """
        self.encoder = encoder
        self._words = words
        self._lexicon = lexicon
        self._name: dict[str, Quantised] = {}

    def features(self, texts: Sequence[str], names: Sequence[str]) -> NDArray[np.float32]:
        """Features of all pairs.

        Args:
            texts: H habits.
            names: C candidate categories.

        Returns:
            (H, C, 6) float32 in the order of :data:`FEATURES`, all within [-1, 1].
        """
        out = np.zeros((len(texts), len(names), N_FEATURES), np.float32)
        if not texts or not names:
            return out
        self._lexical(texts, names, out)
        out[:, :, -2] = self._word_cosine(texts, names)
        sentences = quantise(self.encoder.encode_half(texts))
        out[:, :, -1] = cosines(sentences, self._names(names))
        return out

    def _lexical(self, texts: Sequence[str], names: Sequence[str], out: NDArray[np.float32]) -> None:
        self._lexicon.add(names)
        column = np.full(len(self._lexicon), -1, np.int64)
        column[[self._lexicon.ids[name] for name in names]] = np.arange(len(names))
        found = [self._lexicon.matches(text) for text in texts]
        habit = np.repeat(np.arange(len(texts)), [len(ids) for ids, _ in found])
        candidate = column[np.concatenate([ids for ids, _ in found])]
        values = np.concatenate([values for _, values in found])
        keep = candidate >= 0
        out[habit[keep], candidate[keep], : len(LEXICAL)] = values[keep]

    def _word_cosine(self, texts: Sequence[str], names: Sequence[str]) -> NDArray[np.float32]:
        """Best cosine of a content word of the habit with the name or its head noun, (H, C)."""
        lists = [content_words(text) or ("thing",) for text in texts]
        rows = self._words.rows([word for words in lists for word in words])
        heads = self._words.take(self._words.rows([(tokens(name) or ["thing"])[-1] for name in names]))
        distinct, inverse = np.unique(rows, return_inverse=True)
        words = self._words.take(distinct)
        best = np.maximum(cosines(words, self._names(names)), cosines(words, heads))
        starts = np.cumsum([0] + [len(words) for words in lists[:-1]])
        return np.maximum.reduceat(best[inverse], starts, axis=0)

    def _names(self, names: Sequence[str]) -> Quantised:
        missing = [name for name in dict.fromkeys(names) if name not in self._name]
        if missing:
            vectors = quantise(self.encoder.encode_half([name.replace("_", " ") for name in missing]))
            for i, name in enumerate(missing):
                self._name[name] = vectors.take(np.asarray([i]))
        found = [self._name[name] for name in names]
        return Quantised(np.concatenate([q.codes for q in found]), np.concatenate([q.scale for q in found]))


@lru_cache(maxsize=60_000)
def content_words(text: str) -> tuple[str, ...]:
    """Words of a text that carry meaning, unstemmed and in lower case; the keys of the word vectors."""
    return tuple(word for word in tokens(text) if word not in STOP_WORDS and len(word) > 2)


@cache
def default_pair_reader() -> PairReader:
    """The process's pair reader on the shipped tables."""
    encoder = default_encoder()
    return PairReader(encoder, WordVectors.load(encoder), catalogue_lexicon())
