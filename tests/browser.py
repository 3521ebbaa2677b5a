"""A real headless browser for tests of pages: what a page says on its console, and what it
asks for, is kept."""

import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

import pytest

CHROMIUM = os.environ.get(
    "HEFTING_BROWSER", shutil.which("chromium") or shutil.which("google-chrome")
)
"""Path of the browser, which the environment variable HEFTING_BROWSER may name; none
where there is none, or the variable is empty."""
needs_browser = pytest.mark.skipif(not CHROMIUM, reason="no browser: install chromium")
ARGUMENTS = (
    "--no-sandbox",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--js-flags=--no-opt",
    "--use-angle=swiftshader-webgl",
    "--enable-unsafe-swiftshader",
)
"""WebGL is drawn by the processor, and so is the page, without WebGL; nothing is fetched
in the background, and scripts of a few seconds are not worth the optimising compiler."""
DESKTOP, PHONE = (1440, 900), (390, 844)
"""Sizes of a window [pixels]."""
LOOKS = ((DESKTOP, "light"), (PHONE, "dark"))
"""Each size and each scheme once: what a page does in one of them it does whatever the
other is."""
COARSE = "?fixedDpr=0.25"
"""Lets viser draw a quarter of the pixels each way, and `SELDOM`: a processor is as many
times faster."""
SELDOM = """
if (location.search.includes("fixedDpr")) {
  const next = requestAnimationFrame.bind(window);
  window.requestAnimationFrame = draw => setTimeout(() => next(draw), 100);
  window.cancelAnimationFrame = clearTimeout;
}
"""
"""Ten frames a second, at most: as many as it can would keep a processor busy."""
BLURRED = """
let plotly;
Object.defineProperty(window, "Plotly", {
  get: () => plotly,
  set: (found) => { plotly = found; plotly.setPlotConfig({plotGlPixelRatio: 0.5}); },
});
"""
"""Plotly draws solids with a sixteenth of its pixels."""
LONGEST = 60_000
"""[ms] A busy processor draws what a graphics card draws at once."""
OWN = ("file:", "data:", "blob:", "about:", "http://127.0.0.1", "ws://127.0.0.1")
"""How addresses begin that stay on the machine."""


@dataclass
class Visit:
    """One page in the browser, and what came of it."""

    page: Any
    """Playwright's page"""
    problems: list[str] = field(default_factory=list)
    """errors on the console, and exceptions of scripts"""
    foreign: list[str] = field(default_factory=list)
    """addresses asked for that are not on this machine"""


@contextmanager
def chromium() -> Iterator[Any]:
    """The browser, which the tests of a file share: a visit has a context of its own.

    No longer than a file: while it is open, no event loop can be started beside it.
    """
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(
            executable_path=CHROMIUM, args=list(ARGUMENTS)
        )
        try:
            yield browser
        finally:
            browser.close()


@contextmanager
def browsing(
    browser: Any,
    size: tuple[int, int] = DESKTOP,
    scheme: str = "light",
    offline: bool = False,
) -> Iterator[Visit]:
    """A page in a window of a size [pixels] and a colour scheme, ``light`` or ``dark``;
    `offline` for pages that need no server."""
    context = browser.new_context(
        viewport={"width": size[0], "height": size[1]},
        color_scheme=scheme,
        offline=offline,
        has_touch=size == PHONE,
    )
    context.set_default_timeout(LONGEST)
    context.add_init_script(SELDOM + BLURRED)
    visit = Visit(context.new_page())

    def on_console(message: Any) -> None:
        if message.type == "error":
            visit.problems.append(message.text)

    def on_request(request: Any) -> None:
        if not request.url.startswith(OWN):
            visit.foreign.append(request.url)

    visit.page.on("console", on_console)
    visit.page.on("pageerror", lambda error: visit.problems.append(str(error)))
    visit.page.on("request", on_request)
    try:
        yield visit
    finally:
        context.close()
