"""Controllers: the payload as each robot's controller takes it, to be chosen and
copied."""

from hefting.core.errors import InputError
from hefting.core.estimate import Estimate
from hefting.core.spatial import Array
from hefting.export import REGISTRY, Target, export
from hefting.page.answer import Say
from hefting.page.frame import Section
from hefting.page.html import Markup, element, items, join


def controllers(estimate: Estimate, flange: Array | None, say: Say) -> Section:
    """A select box of controllers, and the text for each."""
    shown = [t for t in REGISTRY.values() if _is_controller(t)]
    choices = [element("option", t.description, value=t.name) for t in shown]
    texts = [_target(estimate, target, flange, say) for target in shown]
    label = element("label", "Robot: ", element("select", *choices, id="controller"))
    button = element("button", "Copy", data_copy="controller-texts", type="button")
    content = join(
        (
            element("p", label, " ", button),
            element("div", *texts, id="controller-texts"),
        )
    )
    return Section("controllers", "Values for a robot's controller", content)


def _is_controller(target: Target) -> bool:
    """Whether it is no file of a simulator, nor a table."""
    return target.write is not None and not target.suffixes


def _target(
    estimate: Estimate, target: Target, flange: Array | None, say: Say
) -> Markup:
    """The lines to paste with what to know before, or why there are none."""
    pose = None if target.in_sensor_axes else flange
    try:
        found = export(estimate, target.name, pose)
    except InputError as error:
        parts = [element("p", say(f"Nothing to paste: {error}."))]
    else:
        notes = items([say(line) for line in found.warnings], class_="note")
        parts = [notes, element("pre", found.text, class_="wrap")]
    return element("div", *parts, data_target=target.name)


def command(words: str | None) -> Section | None:
    """The command, to be copied; None where the page was not made by one."""
    if words is None:
        return None
    button = element("button", "Copy", data_copy="command-text", type="button")
    text: Markup = element("pre", words, class_="wrap", id="command-text")
    return Section("command", "The command", join((text, button)))
