"""From shapes to PyBullet bodies: for collisions in the simulation, visual ones for the camera."""

from pathlib import Path
from typing import Any

from kinematics.geometry import meshes
from kinematics.geometry.transforms import rotation_from_quaternion, rpy_from_rotation
from kinematics.shapes.bodies import Body, Colour
from kinematics.shapes.shapes import Box, Compound, Convex, Cylinder, Hull, Piece, Sphere, points_of
from kinematics.simulation import pybullet_loading

ROLLING = 2e-3  # friction of round bodies, as on a tablecloth; with a tenth of it they never stop rolling
_GLOSS = (0.1, 0.1, 0.1)


class CollisionBodies:
    """The collision bodies of one simulation; equal shapes share their geometry."""

    def __init__(self, world: Any, client: int, folder: Path) -> None:
        self._world, self._client, self._folder = world, client, folder
        self._shapes: dict[Convex, int] = {}
        self._files: dict[tuple[Compound, float], Path] = {}

    def clear(self) -> None:
        """Forget all shapes, after the simulation was reset."""
        self._shapes.clear()

    def add(self, body: Body, may_sleep: bool = False) -> int:
        """Add a body, and return its identity in PyBullet.

        Args:
            may_sleep: at rest it costs no time; convex shapes then have maximal coordinates, which is faster.
        """
        is_compound = isinstance(body.shape, Compound)
        identity = self._compound(body) if is_compound else self._convex(body, may_sleep)
        friction: dict[str, float] = {"lateralFriction": body.friction}
        if isinstance(body.shape, Sphere | Cylinder | Hull):
            friction |= {"rollingFriction": ROLLING, "spinningFriction": ROLLING}
        self._world.changeDynamics(identity, -1, **friction, physicsClientId=self._client)
        if may_sleep and not body.is_fixed:
            state = self._world.ACTIVATION_STATE_ENABLE_SLEEPING
            self._world.changeDynamics(identity, -1, activationState=state, physicsClientId=self._client)
        return identity

    def _convex(self, body: Body, maximal: bool) -> int:
        shape = body.shape
        assert not isinstance(shape, Compound)
        if shape not in self._shapes:
            self._shapes[shape] = self._world.createCollisionShape(
                **_geometry(self._world, shape, "height"), physicsClientId=self._client
            )
        identity: int = self._world.createMultiBody(
            body.mass,
            self._shapes[shape],
            -1,
            body.position,
            body.quaternion_xyzw,
            useMaximalCoordinates=maximal,
            physicsClientId=self._client,
        )
        return identity

    def _compound(self, body: Body) -> int:
        """Load a compound from a URDF, since long arrays of shapes crash PyBullet."""
        shape = body.shape
        assert isinstance(shape, Compound)
        key = (shape, body.mass)
        if key not in self._files:
            self._files[key] = self._folder / f"compound{len(self._files)}.urdf"
            self._files[key].write_text(self._urdf(shape, body.mass))
        with pybullet_loading.output_silenced():
            identity: int = self._world.loadURDF(
                str(self._files[key]),
                body.position,
                body.quaternion_xyzw,
                useFixedBase=body.is_fixed,
                physicsClientId=self._client,
            )
        return identity

    def _urdf(self, shape: Compound, mass: float) -> str:
        pieces = "\n".join(self._collision(piece) for piece in shape.pieces)  # PyBullet breaks long lines
        inertia = 'ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"'  # PyBullet computes it from the shape
        inertial = f'<inertial><mass value="{mass}"/><inertia {inertia}/></inertial>'
        return f'<robot name="compound"><link name="base">{inertial}{pieces}</link></robot>'

    def _collision(self, piece: Piece) -> str:
        xyz = " ".join(f"{v:.9g}" for v in piece.position)
        angles = rpy_from_rotation(rotation_from_quaternion(piece.quaternion_xyzw))
        rpy = " ".join(f"{v:.9g}" for v in angles)
        return (
            f'<collision><origin xyz="{xyz}" rpy="{rpy}"/><geometry>{self._element(piece.shape)}</geometry>'
            "</collision>"
        )

    def _element(self, shape: Convex) -> str:
        if isinstance(shape, Box):
            return f'<box size="{" ".join(f"{2 * half:.9g}" for half in shape.half_extents)}"/>'
        if isinstance(shape, Cylinder):
            return f'<cylinder radius="{shape.radius:.9g}" length="{shape.height:.9g}"/>'
        if isinstance(shape, Sphere):
            return f'<sphere radius="{shape.radius:.9g}"/>'
        path = self._folder / f"hull{len(list(self._folder.glob('hull*.obj')))}.obj"
        path.write_text(meshes.hull_as_obj(points_of(shape)))
        return f'<mesh filename="{path}"/>'


def add_visual_body(world: Any, client: int, piece: Piece, colour: Colour) -> int:
    """Add a body without collisions, and return its identity in PyBullet."""
    shape = world.createVisualShape(
        **_geometry(world, piece.shape, "length"),
        rgbaColor=colour,
        specularColor=_GLOSS,
        physicsClientId=client,
    )
    identity: int = world.createMultiBody(0, -1, shape, piece.position, physicsClientId=client)
    return identity


def _geometry(world: Any, shape: Convex, along: str) -> dict[str, Any]:
    """Return PyBullet's arguments; it calls a cylinder's length `height` for contact, `length` for looks."""
    if isinstance(shape, Box):
        return {"shapeType": world.GEOM_BOX, "halfExtents": shape.half_extents}
    if isinstance(shape, Cylinder):
        return {"shapeType": world.GEOM_CYLINDER, "radius": shape.radius, along: shape.height}
    if isinstance(shape, Sphere):
        return {"shapeType": world.GEOM_SPHERE, "radius": shape.radius}
    if along == "height":
        return {"shapeType": world.GEOM_MESH, "vertices": shape.points}
    vertices, indices = meshes.hull_triangles(points_of(shape))
    return {"shapeType": world.GEOM_MESH, "vertices": vertices, "indices": indices}
