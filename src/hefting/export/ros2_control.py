"""ros2_control: parameters that compensate gravity, as a YAML file of parameters."""

from hefting.core.quantity import decimals, rounded
from hefting.core.spatial import STANDARD_GRAVITY
from hefting.export.body import LEAST_DIGITS, Body
from hefting.export.known import in_double, remarks
from hefting.export.target import Target

FRAMES = {"sensor": "ft_sensor", "flange": "tool0"}
"""Names of frames to be replaced by the robot's own."""


def write(body: Body) -> str:
    """Parameters of three programs that remove the load's weight; kg, m, N; none takes
    an inertia.

    - the filter control_filters/GravityCompensationWrench (control_toolbox,
      gravity_compensation.hpp: tool.mass, tool.CoG, tool.gravity_field), in the filter
      chain of force_torque_sensor_broadcaster. Releases before 2025 call them CoG.pos
      and CoG.force, the force in world axes;
    - admittance_controller (ros2_controllers, admittance_controller_parameters.yaml):
      CoG.force is the weight, and its gravity points down along z;
    - cartesian_force_controller (fzi cartesian_controllers, issues 70 and 100): read by
      its ROS 1 version only.

    All subtract a weight that points down: they assume that the sensor measures the force
    of the load on it.
    """
    mass, x, y, z = in_double((body.mass, *body.center_of_mass))
    g = -STANDARD_GRAVITY[2]
    places = decimals(body.half_widths.mass * g, body.mass * g, LEAST_DIGITS)
    weight = in_double(rounded(body.mass * g, places))[0]
    frame = FRAMES[body.frame]
    return (
        remarks(
            "#",
            body,
            "kg, m, N; no controller here takes an inertia",
            f"rename '{frame}' to your {body.frame} frame, 'world' to one whose z points up",
            "keep one of the three: each removes the weight once; the sensor must count",
            "  the force of the load on it, as most drivers do",
        )
        + f"""force_torque_sensor_broadcaster:
  ros__parameters:
    sensor_filter_chain:
      filter1:
        name: gravity_compensation
        type: control_filters/GravityCompensationWrench
        params:
          world_frame: world
          sensor_frame: {frame}
          tool:
            mass: {mass}
            CoG: [{x}, {y}, {z}]
            gravity_field: [0.0, 0.0, {-g}]
admittance_controller:
  ros__parameters:
    fixed_world_frame:
      frame:
        id: world
    gravity_compensation:
      frame:
        id: {frame}
      CoG:
        pos: [{x}, {y}, {z}]
        force: {weight}
# ROS 1 alone, and there without the line ros__parameters
cartesian_force_controller:
  ros__parameters:
    ft_sensor_ref_link: {frame}
    gravity: {{x: 0.0, y: 0.0, z: {-g}}}
    tool: {{mass: {mass}, com_x: {x}, com_y: {y}, com_z: {z}}}
"""
    )


TARGET = Target(
    name="ros2-control",
    description="ros2_control: gravity compensation as YAML (mass and COM only)",
    write=write,
    takes_inertia=False,
)
