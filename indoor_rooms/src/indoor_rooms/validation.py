"""What is physically wrong with a room: things that intersect or float, hidden targets, broken meshes.

Exact, on triangles: a generator that places things by their bounding boxes is judged by something else than itself.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from indoor_rooms.collision import DIRECTIONS, TOLERANCE, Solid, distance_from_hull, gaps_below, intersection
from indoor_rooms.free_space import FreeSpaceError, free_positions
from indoor_rooms.geometry.mesh import Mesh
from indoor_rooms.geometry.pieces import bounds
from indoor_rooms.objects import OBJECTS
from indoor_rooms.renderer.raycast import RayCaster
from indoor_rooms.room import Room

SHELL = frozenset({"wall", "window", "outside", "floor", "ceiling", "door", "curtain", "blinds"})
# These are built into each other: where exactly one ends inside another is nobody's concern.
FITTED = SHELL | {
    *("baseboard", "cabinet", "countertop", "faucet", "hood", "shelf", "sink", "splashback", "stove", "wall_cabinet")
}
MOST_TRIANGLES = 250_000
# Standing: this share of a thing's lowest vertices (within BASE of the lowest) lies at most REACH above something,
# and its centre of mass is at most BALANCE beyond the hull of all that is so near above something. Metres.
SUPPORTED = 0.6
BASE = 0.002
REACH = 0.004
BALANCE = 0.01
# Furniture's feet are at most this far above floor or rug; what has its back this near a wall may hang there.
FEET = 0.015
HUNG = 0.01
# A thing less than this far above something was meant to stand on it, even with its back to a wall.
HANGING = 0.03
# A target counts as seen from a place this near if this many of its sampled points are. Metres.
NEAR = 1.5
SURFACE_POINTS = 24
SEEN_POINTS = 3


def room_problems(
    room: Room,
    *,
    spacing: float = 0.35,
    radius: float = 0.2,
    smallest_free: int = 25,
    camera_height: float = 1.25,
) -> list[str]:
    """Everything that is physically wrong with a room.

    Args:
        room: what to judge. Its parts count as one object when they have the same name.
        spacing: of the robot's positions, metres.
        radius: of the robot, metres.
        smallest_free: how many positions it shall at least have.
        camera_height: of its camera above the floor, metres.

    Returns:
        Sentences that name the things and the numbers; empty if the room is sound.
    """
    if broken := list(_broken_meshes(room)):
        return broken
    meshes: dict[str, list[Mesh]] = {}
    for part in room.parts:
        meshes.setdefault(part.object_name, []).append(part.mesh)
    bodies = {name: Solid(name, group) for name, group in meshes.items()}
    glowing = {lamp.object_name for lamp in room.lamps}
    return [
        *_winding(room),
        *_lights(room, set(bodies)),
        *_beyond_the_walls(room, list(bodies.values())),
        *_intersections(list(bodies.values()), glowing),
        *_floating_things(room, list(bodies.values())),
        *_floating_furniture(room, bodies),
        *_searching(room, bodies, spacing, radius, smallest_free, camera_height),
    ]


def stem(name: str) -> str:
    """An object's name without its number: "mug_2" is a mug."""
    return re.sub(r"_\d+$", "", name)


def _broken_meshes(room: Room) -> Iterator[str]:
    """Meshes no ray can be cast at."""
    for part in room.parts:
        mesh = part.mesh
        if len(mesh.faces) == 0:
            yield f"{part.object_name} has a mesh without triangles"
        elif mesh.faces.min() < 0 or mesh.faces.max() >= len(mesh.vertices):
            yield f"{part.object_name} has triangles whose vertices do not exist"
        elif not all(np.isfinite(array).all() for array in (mesh.vertices, mesh.normals, mesh.uvs)):
            yield f"{part.object_name} has vertices, normals or texture coordinates that are not finite"


def _winding(room: Room) -> Iterator[str]:
    """Normals that are not of unit length or disagree with their triangles, and too many triangles."""
    for part in room.parts:
        lengths = np.linalg.norm(part.mesh.normals, axis=1)
        if (worst := np.abs(lengths - 1).max()) > 1e-6:
            yield f"{part.object_name} has normals whose length is off by {worst:.2g}"
        a, b, c = (part.mesh.vertices[part.mesh.faces[:, corner]] for corner in range(3))
        winding = np.cross(b - a, c - a)
        agreement = (winding * part.mesh.normals[part.mesh.faces].mean(axis=1)).sum(axis=1)
        # Slivers have no direction to speak of.
        wrong = int(((agreement <= 0) & (np.linalg.norm(winding, axis=1) > 2e-9)).sum())
        if wrong:
            yield f"{part.object_name} has {wrong} of {len(winding)} triangles wound against their normals"
    triangles = sum(len(part.mesh.faces) for part in room.parts)
    if triangles >= MOST_TRIANGLES:
        yield f"the room has {triangles} triangles, {MOST_TRIANGLES} or more"


def _lights(room: Room, names: set[str]) -> Iterator[str]:
    for lamp in room.lamps:
        if lamp.object_name not in names:
            yield f"the lamp '{lamp.object_name}' is no part of the room"
    if room.sun is not None and not room.sun.direction[2] < 0:
        yield f"the sun shines upwards: its direction is {_place(np.array(room.sun.direction))}"


def _beyond_the_walls(room: Room, bodies: Sequence[Solid]) -> Iterator[str]:
    recesses = [bounds([part.mesh]) for part in room.parts if stem(part.object_name) == "window"]
    for body in bodies:
        beyond = max(float((-body.low).max()), float((body.high - room.size).max()))
        if stem(body.name) in SHELL or beyond <= TOLERANCE:
            continue
        if not any(_on_sill(body, recess, np.array(room.size)) for recess in recesses):
            yield f"{body.name} reaches {_mm(beyond)} out of the room"


def _on_sill(body: Solid, recess: NDArray[np.float64], size: NDArray[np.float64]) -> bool:
    """Whether what lies beyond the walls is in the recess of a window with these bounds (2, 3)."""
    low, high = recess[0] - TOLERANCE, recess[1] + TOLERANCE
    through = (recess[0] < -TOLERANCE) | (recess[1] > size + TOLERANCE)
    # Across the wall the recess is open to the room.
    low[through], high[through] = np.minimum(low, 0)[through], np.maximum(high, size)[through]
    return bool(((body.low >= low) & (body.high <= high)).all())


def _intersections(bodies: Sequence[Solid], glowing: set[str]) -> Iterator[str]:
    # Of two things the smaller one is named first.
    for first, second in combinations(sorted(bodies, key=lambda body: float(np.prod(body.high - body.low))), 2):
        fitted = stem(first.name) in FITTED and stem(second.name) in FITTED
        # A bulb is screwed into its lamp.
        bulb = any(a.name in glowing and "lamp" in b.name for a, b in ((first, second), (second, first)))
        if not fitted and not bulb and (found := intersection(first, second)):
            yield f"{first.name} intersects {second.name} by {_mm(found.depth)} at {_place(found.place)}"


def _floating_things(room: Room, bodies: Sequence[Solid]) -> Iterator[str]:
    for thing in bodies:
        if stem(thing.name) not in OBJECTS:
            continue
        heights = thing.vertices[:, 2] - thing.low[2]
        feet, base = thing.vertices[heights < REACH], heights[heights < REACH] < BASE
        gaps, below = gaps_below(feet, [body for body in bodies if body is not thing])
        resting = gaps <= REACH
        if not resting.any():
            if not (gaps.min() > HANGING and _at_wall(room, thing)):
                height = "over nothing" if below == "nothing" else f"{_mm(float(gaps.min()))} above {below}"
                yield f"{thing.name} floats {height}"
        elif resting[base].mean() < SUPPORTED:
            yield f"{thing.name} rests on {below} with only {100 * resting[base].mean():.0f} % of its foot"
        elif (beyond := distance_from_hull(thing.centre_of_mass[:2], feet[resting, :2])) > BALANCE:
            yield f"{thing.name} tips over: its weight is {_mm(beyond)} beyond what supports it on {below}"


def _floating_furniture(room: Room, bodies: dict[str, Solid]) -> Iterator[str]:
    rugs = [body for name, body in bodies.items() if stem(name) == "rug"]
    for name in dict.fromkeys(label for label, _ in room.obstacles):
        if name not in bodies or stem(name) in SHELL or stem(name) in OBJECTS or _at_wall(room, bodies[name]):
            continue
        low, foot = bodies[name].low[2], bodies[name].vertices[bodies[name].vertices[:, 2].argmin()]
        ground = max([0.0, *(rug.high[2] for rug in rugs if ((foot >= rug.low) & (foot <= rug.high))[:2].all())])
        if low - ground > FEET:
            yield f"{name} floats {_mm(low - ground)} above {'the floor' if ground == 0 else 'a rug'}"


def _at_wall(room: Room, body: Solid) -> bool:
    """Whether a body's back is at a wall."""
    return bool(np.abs([body.low[:2], body.high[:2] - room.size[:2]]).min() < HUNG)


def _searching(
    room: Room, bodies: dict[str, Solid], spacing: float, radius: float, smallest_free: int, camera_height: float
) -> Iterator[str]:
    """Too little room for the robot, and targets it can see from nowhere near."""
    try:
        positions = free_positions(room, spacing, radius)
    except FreeSpaceError as error:
        yield str(error)
        return
    if len(positions) < smallest_free:
        yield f"a robot has only {len(positions)} free positions in one connected part, fewer than {smallest_free}"
    everything = RayCaster(np.concatenate([body.triangles for body in bodies.values()]).astype(np.float32))
    cameras = np.column_stack([positions, np.full(len(positions), camera_height)])
    for name in room.targets:
        if name not in bodies:
            yield f"the target '{name}' is no part of the room"
            continue
        middle = (bodies[name].low + bodies[name].high) / 2
        near = np.linalg.norm(positions - middle[:2], axis=1) <= NEAR
        if not near.any():
            yield f"{name} at {_place(middle)} is more than {NEAR} m from every free position"
        elif (most := _points_in_sight(bodies[name], cameras[near], everything)) < SEEN_POINTS:
            yield (
                f"{name} at {_place(middle)} is hidden: from no free position within {NEAR} m are more than "
                f"{most} of {SURFACE_POINTS} points of it in sight"
            )


def _points_in_sight(target: Solid, cameras: NDArray[np.float64], everything: RayCaster) -> int:
    """How many points of a target's surface the best of some cameras (N, 3) sees."""
    points = _outer_points(target)
    start, end = np.repeat(cameras, len(points), axis=0), np.tile(points, (len(cameras), 1))
    length = np.linalg.norm(end - start, axis=1)
    ways = ((end - start) / length[:, None]).astype(np.float32)
    hidden = everything.occluded(start.astype(np.float32), ways, (length - TOLERANCE / 2).astype(np.float32))
    return int((~hidden).reshape(len(cameras), -1).sum(axis=1).max())


def _outer_points(target: Solid) -> NDArray[np.float64]:
    """SURFACE_POINTS or fewer points (N, 3) that could be seen if there were nothing else: no pages inside a book."""
    rng = np.random.default_rng(0)
    chosen = rng.choice(len(target.areas), 60 * SURFACE_POINTS, p=target.areas / target.areas.sum())
    weights = rng.dirichlet(np.ones(3), len(chosen))
    points = (target.triangles[chosen] * weights[..., None]).sum(axis=1)
    ways = DIRECTIONS[DIRECTIONS[:, 2] > -0.5]
    away = np.tile(ways, (len(points), 1)).astype(np.float32)
    starts = np.repeat(points, len(ways), axis=0).astype(np.float32) + away * np.float32(TOLERANCE / 4)
    outer = ~target.caster.occluded(starts, away).reshape(len(points), -1).all(axis=1)
    return points[outer][:SURFACE_POINTS]


def _mm(metres: float) -> str:
    return f"{1000 * metres:.0f} mm"


def _place(point: NDArray[np.float64]) -> str:
    return "(" + ", ".join(f"{value:.2f}" for value in point) + ")"
