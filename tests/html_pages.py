"""What a page holds, read from its HTML."""

import json
import re
from html.parser import HTMLParser


def figures_of(page):
    """Figures of a page by name, as its script reads them."""
    text = re.search(r'id="figures">(.*?)</script>', page, re.DOTALL)
    return {figure["name"]: figure for figure in json.loads(text[1])}


def sections_of(page):
    return re.findall(r'<section id="([\w-]+)">', page)


class Words(HTMLParser):
    """What a reader sees, and the tags there are."""

    def __init__(self, page):
        super().__init__()
        self.words, self.tags, self._open = [], [], []
        self.feed(page)

    def handle_starttag(self, tag, attrs):
        self.tags.append((tag, dict(attrs)))
        if tag in ("script", "style"):
            self._open.append(tag)

    def handle_endtag(self, tag):
        if self._open and self._open[-1] == tag:
            self._open.pop()

    def handle_data(self, data):
        if not self._open:
            self.words.append(data)


def text_of(page):
    return " ".join(" ".join(Words(page).words).split())
