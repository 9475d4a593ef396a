"""A headless Chromium for tests of pages; a test fails on any console error or request to another host."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from typing import Any
from urllib.parse import urlsplit

import pytest

#: Schemes of requests that do not leave the page: files, and data within it.
_OWN = ("file", "data", "blob", "about")


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    """The system's Chromium, started once per module: while it runs, no test in this process can use asyncio."""
    playwright = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
    path = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
    if path is None:
        pytest.skip("there is no Chromium here")
    with playwright.sync_playwright() as started:
        found = started.chromium.launch(executable_path=path, args=["--no-sandbox", "--disable-gpu"])
        yield found
        found.close()


@pytest.fixture
def browser_page(browser: Any) -> Iterator[Any]:
    """A new page; at the end of the test it must have had no errors and no requests to other hosts."""
    context = browser.new_context(viewport={"width": 1440, "height": 900})
    context.set_default_timeout(15_000)
    page, wrong = context.new_page(), []
    page.on("console", lambda said: wrong.append(f"console: {said.text}") if said.type == "error" else None)
    page.on("pageerror", lambda error: wrong.append(f"error: {error}"))
    page.on("request", lambda asked: wrong.append(f"asks {asked.url}") if _is_foreign(asked.url) else None)
    yield page
    context.close()
    assert wrong == []


def _is_foreign(url: str) -> bool:
    parts = urlsplit(url)
    return parts.scheme not in _OWN and parts.hostname != "127.0.0.1"


def wider_than_the_window(page: Any) -> float:
    """By how many pixels a page is wider than its window; 0 if no sideways scrolling is needed."""
    return float(page.evaluate("document.documentElement.scrollWidth - document.documentElement.clientWidth"))


def contrast(page: Any, selector: str) -> float:
    """Least contrast (WCAG, 1 to 21) between text and background of the visible elements that match a selector."""
    return float(page.evaluate(_CONTRAST, selector))


_CONTRAST = """selector => {
  const parts = text => (text.match(/[\\d.]+/g) || [0, 0, 0, 0]).map(Number);
  const linear = v => v / 255 <= .03928 ? v / 255 / 12.92 : ((v / 255 + .055) / 1.055) ** 2.4;
  const light = ([r, g, b]) => [r, g, b].map(linear).reduce((sum, v, k) => sum + v * [.2126, .7152, .0722][k], 0);
  const behind = node => {
    for (let at = node; at; at = at.parentElement) {
      const found = parts(getComputedStyle(at).backgroundColor);
      if (found.length < 4 || found[3] > 0) return found;
    }
    return [255, 255, 255];
  };
  let least = 21;
  for (const node of document.querySelectorAll(selector)) {
    if (!node.offsetParent || !node.textContent.trim() || node.disabled) continue;
    const [a, b] = [light(parts(getComputedStyle(node).color)), light(behind(node))].sort((x, y) => y - x);
    least = Math.min(least, (a + .05) / (b + .05));
  }
  return least;
}"""
