"""What a command must do with input it cannot take."""


def refused(result, *words) -> bool:
    """Exit status 2, one line on standard error that holds `words`, nothing on standard
    output."""
    status, out, err = result
    assert (status, out, err.count("\n")) == (2, "", 1), err
    assert "Traceback" not in err
    for word in words:
        assert word in err, err
    return True
