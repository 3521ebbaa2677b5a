"""Progress: who listens hears stage and share, and nobody else anything."""

from hefting.core.progress import each, listening, report


def test_a_listener_hears_the_stage_and_the_share_while_it_listens():
    heard = []
    report("before")
    with listening(lambda stage, share: heard.append((stage, share))):
        report("reading")
        report("fitting", 0.25)
    report("after", 1.0)
    assert heard == [("reading", None), ("fitting", 0.25)]


def test_the_inner_one_of_two_listeners_hears():
    outer, inner = [], []
    with listening(lambda *told: outer.append(told)):
        with listening(lambda *told: inner.append(told)):
            report("inside")
        report("outside")
    assert inner == [("inside", None)]
    assert outer == [("outside", None)]


def test_items_are_reported_before_they_are_given():
    heard = []
    with listening(lambda stage, share: heard.append(share)):
        for number, item in enumerate(each("items", "abcd")):
            assert item == "abcd"[number]
            assert heard == [k / 4 for k in range(number + 1)]
    assert list(each("items", [])) == []
