"""`python docs/animation.py`: draws the moving picture of the README: an arm turns a
hammer while its numbers become sure. Needs `example-robot-data`, for the looks of the
arm."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from importlib import metadata
from io import BytesIO
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LightSource, to_rgb
from matplotlib.figure import Figure
from mpl_toolkits.mplot3d.art3d import Poly3DCollection
from PIL import Image
from trimesh import creation

import hefting
from hefting.core.errors import NotIdentifiableError
from hefting.core.estimate import Estimate
from hefting.core.files import write_atomically
from hefting.core.inertia import InertialParameters
from hefting.core.spatial import Array, rotation_matrices
from hefting.identification import Identification
from hefting.identification.convergence import estimate_until
from hefting.plots.style import BLUE, INK, VERMILION, style
from hefting.robots.arm import Arm
from hefting.scene.headline import plus_minus
from hefting.scene.surface import LinkSurfaces, coarser
from hefting.simulation.faults import WRENCH_NOISE, Faults, Rates
from hefting.simulation.objects import hammer
from hefting.simulation.scenario import Scenario, Simulated, named_object

FILE = Path(__file__).parent / "_static" / "hefting.gif"
URDF = "ur_description/urdf/ur5_robot.urdf"
JOINTS = (
    "shoulder_pan_joint",
    "shoulder_lift_joint",
    "elbow_joint",
    "wrist_1_joint",
    "wrist_2_joint",
    "wrist_3_joint",
)
BASE = np.diag([-1.0, -1.0, 1.0])
"""Axes of the URDF's root in those of the simulated world."""
BIAS = (12.0, -7.0, 14.0, 0.3, -0.2, 0.1)
"""Of the sensor [N, N m]."""
LATE = 0.03
"""[s] of the wrench."""

FRAMES, PER_SECOND, PAUSE = 64, 10, 2500
"""Pictures, pictures a second, and how long the last one stays [ms]."""
SIZE, DPI = (9.0, 4.2), 90
"""Of the picture [in], and dots per inch."""
COLOURS = 96
"""Of the picture: it has few, and its file is smaller so."""
TRIANGLES = 400
"""Of a part at most."""
ELEVATION, AZIMUTH = 16.0, -40.0
"""From where the arm is seen [°]."""
STEEL, GREY, DARK, WOOD = "#7C93A8", "#DADFE4", "#5A6068", "#C79A62"
WATER = 1000.0
"""[kg/m³] Wood floats."""
CENTER = (-0.3, -0.21, 0.69)
"""Of the cube that is seen [m]."""
REACH = 0.36
"""Half its side [m]."""


@dataclass(frozen=True)
class Solid:
    """Triangles in the world at every picture."""

    corners: Array
    """(P, F, 3, 3) [m]"""
    colour: str


@dataclass(frozen=True)
class Band:
    """One number and its 95 % interval over time."""

    label: str
    of: Callable[[InertialParameters], float]
    interval: Callable[[Estimate], Array]
    factor: float = 1.0


BANDS = (
    Band("mass [kg]", lambda body: body.mass, lambda found: found.interval("mass")),
    Band(
        "COM y [mm]",
        lambda body: body.center_of_mass[1],
        lambda found: found.interval("center_of_mass")[:, 1],
        1e3,
    ),
    Band(
        "Jxx [g m²]",
        lambda body: body.inertia_at_com[0, 0],
        lambda found: found.interval("inertia")[:, 0, 0],
        1e3,
    ),
)


def main() -> None:
    """Write the picture."""
    simulated, found, shape = recorded()
    time = simulated.wielding.motion.time
    shown = np.linspace(0, len(time) - 1, FRAMES).round().astype(int)
    estimates = [so_far(found, shape, float(time[k])) for k in shown]
    solids = [*arm(simulated, shown), *held(simulated, shown)]
    body = simulated.wielding.body
    with style():
        pictures = [
            picture_of(solids, estimates[: i + 1], time[shown], body)
            for i in range(FRAMES)
        ]
    write_atomically(FILE, gif(pictures))
    print(f"wrote {FILE}, {FILE.stat().st_size / 1e6:.2f} MB")


# what happens


def recorded() -> tuple[Simulated, Identification, hefting.Shape]:
    """A hammer in a UR5, slower than 0.25 m/s, by a sensor with a bias whose clock is
    late; and what is found from it."""
    thing = named_object("joiners-hammer")
    simulated = Scenario(
        thing,
        motion="random",
        speed_limit=0.25,
        rates=Rates(wrench=100.0, pose=100.0, joints=100.0),
        faults=Faults(wrench_noise=WRENCH_NOISE["ft300"], bias=BIAS, wrench_delay=LATE),
        seed=3,
    ).run()
    shape = thing.points()
    return simulated, hefting.identify(simulated.recording, shape), shape


def so_far(
    found: Identification, shape: hefting.Shape, instant: float
) -> Estimate | None:
    """What is found from the samples up to an instant [s]; None if too little is."""
    try:
        return estimate_until(found.ingested, found.estimator, shape, instant)
    except NotIdentifiableError:
        return None


# where everything is


def arm(simulated: Simulated, shown: np.ndarray) -> Iterator[Solid]:
    """The links at the samples that are shown."""
    files = metadata.files("example-robot-data") or []
    urdf = next(Path(file.locate()) for file in files if str(file).endswith(URDF))
    recording = replace(simulated.recording, joint_names=JOINTS)
    links = Arm.from_urdf(urdf, "tool0", recording)
    position, orientation = links.poses(recording["joint_positions"].values[shown])
    surfaces = LinkSurfaces()
    for i, link in enumerate(links.links):
        looks = [g for g in link.geometries if g.file is not None]
        if not looks or (surface := surfaces.read(looks[-1])) is None:
            continue
        vertices, faces = coarser(*surface, TRIANGLES)
        turned = BASE @ rotation_matrices(orientation[:, i])
        yield Solid(moved(vertices, faces, turned, position[:, i] @ BASE), GREY)


def held(simulated: Simulated, shown: np.ndarray) -> Iterator[Solid]:
    """Sensor, gripper and the parts of the hammer at the samples that are shown."""
    motion = simulated.wielding.motion
    turned, position = rotation_matrices(motion.orientation[shown]), motion.position
    sensor = creation.cylinder(0.036, segment=[[0, 0, 0], [0, 0, 0.03]], sections=32)
    gripper = creation.box(bounds=[[-0.025, -0.02, 0.03], [0.025, 0.02, 0.075]])
    pose = named_object("joiners-hammer").pose
    parts = [(sensor, DARK), (gripper, DARK)]
    for part in hammer().parts:
        mesh = part.mesh(24).apply_transform(pose)
        parts.append((mesh, STEEL if part.density > WATER else WOOD))
    for mesh, colour in parts:
        vertices = np.asarray(mesh.vertices)
        yield Solid(moved(vertices, mesh.faces, turned, position[shown]), colour)


def moved(vertices: Array, faces: np.ndarray, turned: Array, position: Array) -> Array:
    """Corners (P, F, 3, 3) of triangles at poses (P, 3, 3), (P, 3)."""
    return (vertices @ turned.swapaxes(1, 2) + position[:, None])[:, faces]


# how it looks


def picture_of(
    solids: list[Solid],
    estimates: list[Estimate | None],
    time: Array,
    body: InertialParameters,
) -> Image.Image:
    """The picture after so many estimates."""
    figure = Figure(figsize=SIZE, dpi=DPI)
    draw_solids(figure, solids, len(estimates) - 1)
    figure.text(0.98, 0.955, "95 % interval", size=8, color=BLUE, ha="right")
    figure.text(0.86, 0.955, "truth", size=8, color=VERMILION, ha="right")
    for row, band in enumerate(BANDS):
        axes = figure.add_axes((0.68, 0.72 - 0.295 * row, 0.3, 0.23))
        draw_band(axes, band, estimates, time, band.factor * band.of(body))
        if row < len(BANDS) - 1:
            axes.set_xticklabels([])
        else:
            axes.set_xlabel("time [s]")
    figure.text(0.02, 0.92, said(estimates[-1]), size=13, color=INK, weight="bold")
    facts = "below 0.25 m/s; the sensor's bias of 20 N and delay of 30 ms are found too"
    figure.text(0.02, 0.865, facts, size=8.5, color=INK)
    data = BytesIO()
    figure.savefig(data, format="png")
    return Image.open(data).convert("RGB")


def said(estimate: Estimate | None) -> str:
    """The mass as far as it is known."""
    if estimate is None:
        return "what does the robot hold?"
    low, high = estimate.interval("mass")
    return f"it holds {plus_minus(estimate.mass, 0.5 * (high - low))} kg"


def draw_solids(figure: Figure, solids: list[Solid], i: int) -> None:
    """Arm and hammer at one picture."""
    axes = figure.add_axes((-0.06, -0.22, 0.74, 1.3), projection="3d")
    axes.view_init(ELEVATION, AZIMUTH)
    light = LightSource(azdeg=-60.0, altdeg=50.0)
    every = np.concatenate([solid.corners[i] for solid in solids])
    normals = np.cross(every[:, 1] - every[:, 0], every[:, 2] - every[:, 0])
    size = np.linalg.norm(normals, axis=1, keepdims=True)
    normals = np.divide(normals, size, where=size > 0.0, out=np.zeros_like(normals))
    shade = 0.55 + 0.45 * np.abs(normals @ light.direction)
    colours = np.concatenate(
        [np.tile(to_rgb(solid.colour), (len(solid.corners[i]), 1)) for solid in solids]
    )
    axes.add_collection3d(
        Poly3DCollection(every, facecolors=colours * shade[:, None], linewidths=0)
    )
    for name, center in zip("xyz", CENTER, strict=True):
        getattr(axes, f"set_{name}lim")(center - REACH, center + REACH)
    axes.set_box_aspect((1, 1, 1), zoom=1.25)
    axes.set_axis_off()


def draw_band(
    axes: Axes,
    band: Band,
    estimates: list[Estimate | None],
    time: Array,
    truth: float,
) -> None:
    """A number and its interval so far, with the truth."""
    ends = np.array(
        [
            [np.nan] * 2 if each is None else band.factor * band.interval(each)
            for each in estimates
        ]
    )
    values = [
        np.nan if each is None else band.factor * band.of(each.parameters)
        for each in estimates
    ]
    own = time[: len(estimates)]
    axes.axhline(truth, color=VERMILION, linewidth=1.0, linestyle="--")
    axes.fill_between(own, *ends.T, color=BLUE, alpha=0.25, linewidth=0)
    axes.plot(own, values, color=BLUE, linewidth=1.4)
    axes.set_xlim(0.0, time[-1])
    axes.set_ylim(0.0, 2.0 * truth)
    axes.tick_params(labelsize=8)
    axes.set_ylabel(band.label, fontsize=8.5)
    axes.set_xticks(np.arange(0.0, time[-1] + 0.1, 2.0))


def gif(pictures: list[Image.Image]) -> bytes:
    """The pictures one after the other."""
    palette = pictures[-1].quantize(COLOURS)
    first, *others = [
        each.quantize(palette=palette, dither=Image.Dither.NONE) for each in pictures
    ]
    data = BytesIO()
    first.save(
        data,
        "gif",
        save_all=True,
        append_images=others,
        duration=[1000 // PER_SECOND] * (FRAMES - 1) + [PAUSE],
        loop=0,
        optimize=True,
    )
    return data.getvalue()


if __name__ == "__main__":
    main()
