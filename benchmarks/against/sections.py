"""Rows with goals: how much faster than each peer, and how accurate beside the best of
them.

The goals are those of the project, not chosen by what is reached: PMD and GEO a hundred
times as fast as CVXPY with Clarabel and LMI twenty-five times, none slower than a peer,
and the default method, Bayes, at least as accurate as the best peer in each quantity,
always a body, its intervals as good as they say. They hold for every set-up of a peer.
"""

from collections.abc import Sequence

from benchmarks.against.cost import Curve
from benchmarks.against.ours import BARE
from benchmarks.against.runs import QUANTITIES, Outcome
from benchmarks.report import Row, Section

DEFAULT = "Hefting Bayes"
FASTER = {"PMD": 100.0, "GEO": 100.0, "LMI": 25.0}
"""Times as fast as CVXPY with Clarabel, by method."""
NOT_SLOWER = 1.0
"""Times as fast as any other peer."""
BESIDE_BEST = 1.0
"""Of the best peer's error."""
NOMINAL = 95.0
"""Percent of the intervals that hold the truth."""
BEST = "/best peer"
"""Ends the names of errors over the best peer's."""


def goal(peer: str) -> float:
    """Times as fast as this peer."""
    return next(
        (
            times
            for method, times in FASTER.items()
            if peer.startswith("CVXPY") and method in peer
        ),
        NOT_SLOWER,
    )


def of_set(name: str, samples: int, outcomes: Sequence[Outcome]) -> Section:
    """Every peer's time beside Hefting's, and the default method beside the best."""
    where = f"{name}, {samples:,} samples"
    by_name = {outcome.party.name: outcome for outcome in outcomes}
    peers = [outcome for outcome in outcomes if outcome.party.peer]
    rows = []
    for peer in peers:
        ours = by_name[peer.party.beside]
        ratio = peer.timing.median / ours.timing.median
        rows += [
            Row(peer.party.name, peer.timing),
            Row(
                f"  {ours.party.name.removesuffix(BARE)}",
                ours.timing,
                ratio,
                "x",
                at_least=goal(peer.party.name),
                name=f"peers, {where}, {peer.party.name}",
            ),
        ]
    rows += accuracy(where, by_name[DEFAULT], peers)
    return Section(f"against peers, {where}", tuple(rows))


def accuracy(where: str, ours: Outcome, peers: Sequence[Outcome]) -> list[Row]:
    """The default method's errors over the best peer's, and what its answers are."""
    rows = []
    for i, quantity in enumerate(QUANTITIES if peers else ()):
        best = min(peer.median_errors[i] for peer in peers)
        rows.append(
            Row(
                f"{DEFAULT}, median error of the {quantity}, over the best peer's",
                figure=float(ours.median_errors[i] / best),
                unit="of best",
                at_most=BESIDE_BEST,
                name=f"peers, {where}, {quantity}{BEST}",
            )
        )
    said = ours.to_dict()
    return [
        *rows,
        Row(
            f"{DEFAULT}, answers that are bodies",
            figure=said["consistent"],
            unit="%",
            at_least=100.0,
        ),
        Row(
            f"{DEFAULT}, 95 % intervals that hold the truth",
            figure=said["held"],
            unit="%",
            at_least=NOMINAL,
        ),
    ]


def of_cost(cost: dict[str, dict[str, Curve]], beside: dict[str, str]) -> Section:
    """Each peer at the largest size that it and Hefting reached."""
    rows = []
    for what, curves in cost.items():
        for peer, curve in curves.items():
            ours = curves.get(beside.get(peer, ""))
            if ours is None:
                continue
            size, theirs = curve["at"][-1], curve["seconds"][-1]
            mine = ours["seconds"][ours["at"].index(size)]
            rows.append(
                Row(
                    f"{peer} over {beside[peer].removesuffix(BARE)}, {size:,} "
                    + (what if size > 1 else what.removesuffix("s")),
                    figure=theirs / mine,
                    unit="times",
                    at_least=goal(peer),
                )
            )
    return Section("against peers, cost", tuple(rows))
