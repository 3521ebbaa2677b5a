"""
Many recordings, and a table of them
====================================

A folder of logs becomes a table with a row for each, which pandas, polars and DuckDB read. This example records a shelf
of hammers, identifies them all, and asks DuckDB how well recordings of the same one agree.

Run it with ``pip install 'hefting[plot]' duckdb`` and ``python examples/many_recordings.py``.
"""

# %%
# A shelf of hammers
# ------------------
# With heads of four lengths, each recorded twice; one recording is broken. The manifest, as from a database or a
# spreadsheet, has a row for each recording, with the object that it shows.

from pathlib import Path

import duckdb

import hefting
from hefting.plots import save_figure
from hefting.plots.style import BLUE, INK, VERMILION, drawing
from hefting.simulation import UR5, HeldObject, random_smooth, simulate
from hefting.simulation.demo import POSE
from hefting.simulation.objects import ASH_WOOD, STEEL, Assembly, Part

HEADS = {"short": 0.04, "middle": 0.06, "long": 0.08, "sledge": 0.12}  # lengths [m]


def body_of(head: float) -> hefting.InertialParameters:
    """A hammer with such a steel head, in the sensor frame."""
    handle = Part("cylinder", (0.014, 0.260), ASH_WOOD, (0.0, 0.0, 0.130))
    steel = Part("box", (head, 0.028, 0.032), STEEL, (0.0, 0.0, 0.276))
    return HeldObject.of(Assembly("hammer", (handle, steel)), POSE).parameters


def write_shelf() -> list[dict[str, str]]:
    """Write the logs; the rows of a manifest."""
    Path("shelf").mkdir(exist_ok=True)
    rows = []
    for name, head in HEADS.items():
        for run in range(2):
            seed = 10 * len(rows) + run
            motion = UR5.motion(random_smooth(5.0, 100.0, 0.8, seed=seed))
            noise = hefting.NOISE_LEVELS["moderate"]
            path = f"shelf/{name}-{run}.csv"
            hefting.write_log(
                simulate(motion, body_of(head), noise=noise, seed=seed), path
            )
            rows.append({"recording": path, "object": name})
    Path(rows[-1]["recording"]).write_text("time,px\n")
    return rows


# %%
# A question in SQL
# -----------------
# The table is a folder of Parquet files; intervals are columns like others.

QUERY = """
    SELECT object, mass, intervals.mass[1] AS low, intervals.mass[2] AS high, error_text
    FROM 'results/*.parquet'
"""
AGREEMENT = """
    SELECT object, count(mass) AS recordings, avg(mass) AS mean, stddev_samp(mass) AS spread
    FROM 'results/*.parquet' GROUP BY object ORDER BY mean
"""

# %%
# All of them
# -----------
# Local processes share the work. They import the script once more, hence the guard. A recording that cannot be
# identified has a row too, which says why; the others continue.
#
# The figure shows the error of the mass of each recording, with its 95 % interval.

if __name__ == "__main__":
    done = hefting.batch(write_shelf(), "results", jobs=2)
    print(done.summary.verdicts, "failed:", done.summary.failed)
    for reason in done.summary.reasons:
        print("-", reason.text)
    print(duckdb.sql(AGREEMENT))

    with drawing(2.2, width=5.5) as figure:
        axes = figure.subplots()
        found = duckdb.sql(QUERY).fetchall()
        for row, (name, *kilograms, error) in enumerate(found):
            if error:
                axes.annotate("failed", (0.5, row), va="center", color=VERMILION)
                continue
            true = body_of(HEADS[name]).mass
            mass, low, high = (1e3 * (each - true) for each in kilograms)
            axes.plot((low, high), (row, row), color=BLUE, linewidth=3.0, alpha=0.5)
            axes.plot(mass, row, "o", color=BLUE, markersize=4)
        axes.axvline(0.0, color=INK, linewidth=0.6)
        axes.set_yticks(range(len(found)), [name for name, *_ in found])
        axes.set(xlabel="mass found less true mass [g]", ylim=(len(found) - 0.4, -0.6))
    save_figure(figure, "many_recordings")
