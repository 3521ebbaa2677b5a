"""The gallery: which examples it has, in which order, and how their figures come onto
their pages."""

import re
import shutil
from pathlib import Path
from textwrap import indent
from typing import Any

from PIL import Image
from sphinx_gallery.scrapers import figure_rst

from hefting.jobs import source_version

ORDER = (
    "own_arrays",
    "log_step_by_step",
    "turned_sensor",
    "without_a_mesh",
    "gripper_and_object",
    "two_recordings",
    "all_methods",
    "static_poses",
    "joint_torques",
    "live_until_sure",
    "next_motion",
    "many_recordings",
    "drop_in_mujoco",
    "in_a_notebook",
    "error_by_speed",
)
"""Names of the scripts in ``examples/``: first what everybody needs."""
COPY, PAGES, MADE_BY = "_build/examples", "gallery", "made_by"
"""In the folder of the site: where the scripts run, where their pages are written, and
the file there that says from which sources of the library they are."""
ARCHIVE = re.compile(
    r"^ *\.\. container:: sphx-glr-download sphx-glr-download-zip\n\s+:download:.*\n",
    re.MULTILINE,
)
"""What says where an archive is on a page."""
WIDE = 1300
"""Pixels from which on a picture is wider than a printed column; it keeps its size on
phones, and is moved sideways."""


def settings(folder: Path) -> dict[str, Any]:
    """Of sphinx-gallery, for a site in `folder` that has ``examples/`` beside it.

    Scripts run in a copy of their folder, where they may write. A page stays until its
    script or the library changes.
    """
    copy, pages = folder / COPY, folder / PAGES
    shutil.rmtree(copy, ignore_errors=True)
    shutil.copytree(folder.parent / "examples", copy, ignore=_not_sources)
    pages.mkdir(exist_ok=True)
    sources, stamp = source_version(), pages / MADE_BY
    if not stamp.exists() or stamp.read_text(encoding="utf-8") != sources:
        for each in pages.glob("*.md5"):
            each.unlink()
        stamp.write_text(sources, encoding="utf-8")
    return {
        "examples_dirs": COPY,
        "gallery_dirs": PAGES,
        "filename_pattern": "",  # every script is run
        "within_subsection_order": "site_parts.gallery.place",
        "image_scrapers": ("site_parts.gallery.scrape",),
        "reset_modules": (),
        "capture_repr": ("_repr_html_",),
        "abort_on_example_error": True,
        "write_computation_times": False,
        "min_reported_time": 1e9,  # the same page however long it took
        "show_signature": False,
        "download_all_examples": False,
        "thumbnail_size": (600, 420),
        "first_notebook_cell": "%matplotlib inline",
    }


def place(name: str) -> int:
    """Of a script in the gallery."""
    return ORDER.index(Path(name).stem)


def scrape(block: Any, variables: dict[str, Any], configuration: dict[str, Any]) -> str:
    """The pictures that a block has just written, as they are, for its page; the first
    image of a script is a part of the first picture, for its thumbnail."""
    paths, shown = variables["image_path_iterator"], []
    for path in sorted(Path(variables["src_file"]).parent.glob("*.png")):
        with Image.open(path) as picture:
            wide = picture.width > WIDE
            if len(paths) == 0:
                picture.crop(_below_headline(*picture.size)).save(next(paths))
        target = next(paths)
        shutil.move(path, target)
        drawn = figure_rst([target], configuration["src_dir"])
        kind = "drawn wide" if wide else "drawn"
        shown.append(f".. container:: {kind}\n{indent(drawn, '    ')}")
    return "\n".join(shown)


def without_archives(app: Any, name: str, source: list[str]) -> None:
    """Take the archive of each script and its notebook, which are there beside it, off
    its page (``source-read``): no two builds make the same one."""
    if name.startswith(f"{PAGES}/"):
        source[0] = ARCHIVE.sub("", source[0])


def _below_headline(width: int, height: int) -> tuple[int, int, int, int]:
    """Left, upper, right and lower edge of the part of a picture that is still legible
    in a thumbnail: all of one that is about as high as wide, or lower."""
    if height < 1.2 * width:
        return 0, 0, width, height
    top = round(0.13 * height)
    return 0, top, width, top + round(0.7 * width)


def _not_sources(folder: Any, names: list[str]) -> list[str]:
    """What a script has left that was run where it is."""
    return [name for name in names if not name.endswith((".py", ".rst"))]
