"""Palette: the colours of a page, light and dark, by what they are for.

Figures name a colour as ``@name``; the page puts in that of the reader's scheme, and
styles read it as ``var(--name)``. Lines are those of Okabe & Ito (2008), for the
colour-blind, lighter on dark ground.
"""

LIGHT = {
    "paper": "#ffffff",
    "ink": "#222222",
    "muted": "#5c5c5c",
    "grid": "#dddddd",
    "soft": "#f3f3f3",
    "x": "#0072b2",
    "y": "#d55e00",
    "z": "#007d5b",
    "x-pale": "rgba(0,114,178,0.25)",
    "y-pale": "rgba(213,94,0,0.25)",
    "z-pale": "rgba(0,125,91,0.25)",
    "estimate": "#d55e00",
    "truth": "#222222",
    "shape": "#9a9a9a",
    "gravity": "#a8568a",
    "good": "#006e4f",
    "care": "#8a5a00",
    "bad": "#b3261e",
    "contact": "rgba(213,94,0,0.30)",
    "spike": "rgba(168,86,138,0.55)",
    "saturation": "rgba(230,159,0,0.45)",
    "no-pose": "rgba(120,120,120,0.30)",
    "no-wrench": "rgba(60,60,60,0.30)",
    "pose": "rgba(86,180,233,0.40)",
    "touched": "rgba(213,94,0,0.45)",
    "other": "rgba(120,120,120,0.22)",
}
"""On white."""
DARK = LIGHT | {
    "paper": "#16181c",
    "ink": "#e6e6e6",
    "muted": "#a8adb5",
    "grid": "#3a3e45",
    "soft": "#22252b",
    "x": "#56b4e9",
    "y": "#f0883e",
    "z": "#2fbf94",
    "x-pale": "rgba(86,180,233,0.36)",
    "y-pale": "rgba(240,136,62,0.36)",
    "z-pale": "rgba(47,191,148,0.36)",
    "estimate": "#f0883e",
    "truth": "#f2f2f2",
    "shape": "#8c929b",
    "gravity": "#d79ac0",
    "good": "#4ccfa3",
    "care": "#e6b84d",
    "bad": "#ff8a80",
    "contact": "rgba(240,136,62,0.35)",
    "no-pose": "rgba(170,170,170,0.30)",
    "no-wrench": "rgba(220,220,220,0.25)",
    "other": "rgba(170,170,170,0.22)",
}
"""On near black."""


def style_of(colours: dict[str, str]) -> str:
    """Colours as custom properties of CSS."""
    return "".join(f"--{name}:{value};" for name, value in colours.items())
