"""Public names: their examples run as written, and their help can be read."""

import doctest
import inspect
import re
from pathlib import Path

import pytest

import hefting
from demo_files import write_demo
from hefting.core.errors import HeftingError
from jobs_here import do_jobs_here, understand_here
from plans import search_briefly

pytestmark = pytest.mark.usefixtures("same_commands")

LONGEST_SIGNATURE = 1200
"""Characters: NumPy's ArrayLike spelled out in each of its arguments makes 6,000 of
`hefting.identify`."""
NAMES = sorted(
    name
    for name in dir(hefting)
    if name != "__version__" and callable(getattr(hefting, name))
)
ARM = """
<robot name="arm">
  <link name="base"/>
  <link name="tool"/>
  <joint name="turn" type="revolute">
    <parent link="base"/>
    <child link="tool"/>
    <axis xyz="0 0 1"/>
    <limit lower="-3" upper="3" effort="1" velocity="1"/>
  </joint>
</robot>
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A folder with the demo's files and a robot, as the examples suppose."""
    folder = tmp_path_factory.mktemp("examples")
    write_demo(folder / "demo")
    (folder / "arm.urdf").write_text(ARM)
    return folder


@pytest.fixture(scope="module")
def measurements(folder):
    """Those of the demo's recording."""
    return hefting.identify(folder / "demo" / "log.csv").measurements


@pytest.mark.parametrize("name", NAMES)
def test_the_example_runs_as_written(name, folder, measurements, monkeypatch):
    monkeypatch.chdir(folder)
    do_jobs_here(monkeypatch)
    understand_here(monkeypatch)
    search_briefly(monkeypatch)
    names = {"hefting": hefting, "measurements": measurements}
    text = inspect.getdoc(getattr(hefting, name)) or ""
    test = doctest.DocTestParser().get_doctest(text, names, name, None, None)
    assert test.examples, "give it an example"
    said: list[str] = []
    doctest.DocTestRunner().run(test, out=said.append)
    assert not said, "".join(said)


def is_error(name) -> bool:
    value = getattr(hefting, name)
    return isinstance(value, type) and issubclass(value, Exception)


@pytest.mark.parametrize("name", [name for name in NAMES if not is_error(name)])
def test_the_signature_can_be_read(name):
    signature = str(inspect.signature(getattr(hefting, name)))
    assert "numpy._typing" not in signature
    assert "dtype[" not in signature
    assert len(signature) < LONGEST_SIGNATURE


def test_all_errors_that_can_be_raised_are_public():
    """Those of the library; every other exception would be a fault of it."""
    public = {
        value
        for value in (getattr(hefting, name) for name in NAMES)
        if isinstance(value, type) and issubclass(value, HeftingError)
    }
    source = Path(hefting.__file__).parent
    defined = {
        name
        for path in source.rglob("*.py")
        for name in re.findall(
            r"^class (\w+)\((?:HeftingError|\w*Error)\)", path.read_text(), re.M
        )
    }
    assert {"InputError", "NeedError", "NotIdentifiableError"} <= defined
    assert {each.__name__ for each in public} == defined | {"HeftingError"}
