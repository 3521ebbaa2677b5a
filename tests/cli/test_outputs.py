"""Outputs: what must not be replaced, and what happens where nothing can be printed."""

import os
import stat
import subprocess
import sys
from io import BytesIO, TextIOWrapper

import pytest

from commands import refused
from hefting.cli import main
from hefting.core.errors import InputError
from hefting.core.files import write_atomically
from hefting.logs import write_log
from hefting.simulation import UR5, hammer, simulate, sinusoids

pytestmark = pytest.mark.usefixtures("same_commands")

full = pytest.mark.skipif(
    not os.path.exists("/dev/full"), reason="there is no /dev/full"
)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A log and an estimate."""
    folder = tmp_path_factory.mktemp("outputs")
    motion = UR5.motion(sinusoids(4.0, 20.0, 1.0))
    write_log(simulate(motion, hammer().parameters), folder / "log.csv")
    from hefting.identification import identify

    identify(folder / "log.csv").estimate.save(folder / "e.json")
    return folder


@pytest.fixture(params=["link", "hard link", "way around"])
def other_name(request, folder, tmp_path):
    """Another name of a file: the same inode by another path."""

    def other(name):
        path = tmp_path / name
        if request.param == "link":
            path.symlink_to(folder / name)
        elif request.param == "hard link":
            os.link(folder / name, path)
        else:
            path = folder / ".." / folder.name / name
        return path

    return other


@pytest.mark.parametrize(
    ("words", "name"),
    [
        (("convert", "log.csv"), "log.csv"),
        (("calibrate", "log.csv", "--output"), "e.json"),
        (("identify", "log.csv", "--tool", "e.json", "--output"), "e.json"),
        (("predict", "e.json", "log.csv", "--output"), "log.csv"),
        (("export", "e.json", "--to", "json", "--output"), "e.json"),
        (("simulate", "--object", "log.csv"), "log.csv"),
    ],
)
def test_an_input_is_not_overwritten_by_any_name(run, folder, other_name, words, name):
    if words[0] == "calibrate":
        words = ("calibrate", "log.csv", "--map", "e.json", "--output")
    before = (folder / name).read_bytes()
    whole = [folder / word if (folder / word).is_file() else word for word in words]
    assert refused(run(*whole, other_name(name)), "is an input")
    assert (folder / name).read_bytes() == before


@pytest.mark.parametrize("suffix", [".csv", ".parquet", ".mcap", ".bag"])
def test_what_is_no_file_is_not_replaced(run, folder, tmp_path, suffix):
    pipe = tmp_path / f"out{suffix}"
    os.mkfifo(pipe)
    assert refused(run("convert", folder / "log.csv", pipe), "no regular file")
    assert stat.S_ISFIFO(os.stat(pipe).st_mode)


def test_links_to_devices_are_not_replaced(tmp_path):
    link = tmp_path / "out.json"
    link.symlink_to(os.devnull)
    with pytest.raises(InputError, match="no regular file"):
        write_atomically(link, "text")
    assert stat.S_ISCHR(os.stat(os.devnull).st_mode)


def command(*words, **streams):
    """Run ``hefting`` in a process of its own: exit status and standard error."""
    done = subprocess.run(
        [sys.executable, "-m", "hefting", *map(str, words)],
        stderr=subprocess.PIPE,
        text=True,
        **streams,
    )
    return done.returncode, done.stderr


@full
@pytest.mark.parametrize(
    ("words", "unbuffered"),
    [
        (("--help",), ""),
        (("--help",), "1"),
        (("--version",), ""),
        (("methods",), ""),
        (("inspect", "{}"), ""),
        (("inspect", "{}"), "1"),
        (("inspect", "{}", "--json"), ""),
        (("inspect", "{}", "--json"), "1"),
    ],
)
def test_a_full_output_is_an_error_of_one_line(folder, words, unbuffered):
    words = [word.format(folder / "log.csv") for word in words]
    env = {**os.environ, "PYTHONUNBUFFERED": unbuffered}
    with open("/dev/full", "w") as nowhere:
        status, err = command(*words, stdout=nowhere, env=env)
    assert status == 1
    assert err.count("\n") == 1
    assert err.startswith("hefting: standard output cannot be written")


@pytest.mark.skipif(os.name != "posix", reason="closes a descriptor")
def test_a_closed_output_is_no_error(folder):
    status, err = command("inspect", folder / "log.csv", preexec_fn=lambda: os.close(1))
    assert (status, err) == (0, "")


def test_memory_is_an_error_of_one_line(run, folder, monkeypatch):
    def no_memory(*_, **__):
        raise MemoryError

    monkeypatch.setattr("hefting.inspection.inspect", no_memory)
    status, out, err = run("inspect", folder / "log.csv")
    assert (status, out, err.count("\n")) == (1, "", 1)
    assert "not enough memory" in err


@pytest.mark.parametrize(
    ("words", "name"),
    [
        (("identify", "log.csv", "--output"), "e.json"),
        (("convert", "log.csv"), "c.csv"),
        (("convert", "log.csv", "--with", "e.json"), "c.mcap"),
        (("export", "e.json", "--to", "urdf", "--output"), "x.urdf"),
        (("predict", "e.json", "log.csv", "--output"), "p.csv"),
        (("inspect", "log.csv", "--report"), "r.html"),
        (("view", "log.csv", "--save"), "v.html"),
        (("show", "--box", "0.1,0.1,0.1", "--output"), "s.png"),
        (("simulate", "--duration", "1"), "sim.csv"),
    ],
)
def test_names_of_files_do_not_control_a_terminal(
    run, folder, tmp_path, monkeypatch, words, name
):
    monkeypatch.chdir(folder)
    path = tmp_path / f"\x1b[31m{name}"
    status, out, _ = run(*words, str(path))
    assert status == 0
    assert path.exists()
    assert f"?[31m{name}" in out
    assert "\x1b" not in out


def test_errors_do_not_control_a_terminal(run, tmp_path):
    path = tmp_path / "map.toml"
    path.write_bytes(b'"\\u001b[31m\\u0007" = 1\n')
    (tmp_path / "log.csv").write_text("a,b\n1,2\n")
    result = run("inspect", tmp_path / "log.csv", "--map", path)
    assert refused(result, "unknown key")
    assert result[2].strip().isprintable()


@pytest.mark.parametrize(
    ("encoding", "errors"),
    [("cp1252", "strict"), ("ascii", "strict"), ("ascii", "surrogateescape")],
)
def test_an_encoding_without_some_signs_is_no_error(
    folder, monkeypatch, encoding, errors
):
    log = str(folder / "log.csv")
    for words in (["identify", log], ["inspect", log, "--verbose"]):
        out, err = (TextIOWrapper(BytesIO(), encoding, errors) for _ in range(2))
        with monkeypatch.context() as patch:
            patch.setattr(sys, "stdout", out)
            patch.setattr(sys, "stderr", err)
            patch.setattr(sys, "argv", ["hefting", *words])
            main()
        err.flush()
        assert err.buffer.getvalue() == b""
        assert out.buffer.getvalue().decode("cp1252").count("kg") > 1


def test_a_process_without_some_signs_is_no_error(folder):
    """Of the C locale, whose encoding is ASCII."""
    env = {"LC_ALL": "C", "PYTHONCOERCECLOCALE": "0", "PYTHONUTF8": "0"}
    done = subprocess.run(
        [sys.executable, "-m", "hefting", "inspect", folder / "log.csv", "--verbose"],
        env={**os.environ, **env},
        capture_output=True,
    )
    assert (done.returncode, done.stderr) == (0, b"")
    assert done.stdout.decode("ascii").count("kg") > 1


@pytest.mark.skipif(
    sys.platform != "linux", reason="names of files are any bytes on Linux"
)
def test_a_name_that_is_not_utf_8(run, folder, tmp_path):
    log, page = (tmp_path / name for name in ("l\udcf6g.csv", "r\udcf6.html"))
    for path in (log, tmp_path / "log.csv"):
        path.write_bytes((folder / "log.csv").read_bytes())
    for command in ("inspect", "identify"):
        status, _, err = run(command, log, "--report", page)
        assert (status, err) == (0, "")
        assert "l?g.csv" in page.read_text("utf-8")
        status, out, _ = run(command, log, "--json")
        assert "l?g.csv" in out
        assert "udcf6" not in out
    status, out, _ = run("batch", tmp_path, "--output", tmp_path / "results")
    assert (status, "not UTF-8" in " ".join(out.split())) == (0, True)
