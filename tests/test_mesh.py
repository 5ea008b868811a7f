"""The world mesh: closed, facing outwards, and as large as the plan."""

from collections import Counter

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sim.mesh import Mesh, extrude
from slam.pose import FloatArray
from slam.scenario.furniture import Box, Table
from slam.scenario.solids import Prism, rectangle
from slam.scenario.wall import Wall


def polygon(corners: int, radius: float = 1.0) -> Prism:
    angles = 2.0 * np.pi * np.arange(corners) / corners
    return Prism(radius * np.column_stack([np.cos(angles), np.sin(angles)]), 0.5, 2.0)


def edges(mesh: Mesh) -> Counter[tuple[int, int]]:
    a, b, c = mesh.triangles.T
    return Counter(zip(np.concatenate([a, b, c]).tolist(), np.concatenate([b, c, a]).tolist(), strict=True))


def normals(mesh: Mesh) -> np.ndarray:
    a, b, c = mesh.vertices[mesh.triangles].transpose(1, 0, 2)
    return np.cross(b - a, c - a)


def volume(mesh: Mesh) -> float:
    """Compute the volume by the divergence theorem, which holds only if the mesh is closed and faces outwards."""
    a, b, c = mesh.vertices[mesh.triangles].transpose(1, 0, 2)
    return float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6.0)


@pytest.mark.parametrize("corners", [3, 4, 7])
def test_a_prism_is_watertight(corners: FloatArray) -> None:
    mesh = extrude([polygon(corners)])
    assert mesh.vertices.shape == (2 * corners, 3)
    assert mesh.triangles.shape == (4 * corners - 4, 3)
    directed = edges(mesh)
    assert set(directed.values()) == {1}
    assert all((b, a) in directed for a, b in directed)


@pytest.mark.parametrize("corners", [3, 4, 7])
def test_all_normals_of_a_prism_point_outwards(corners: FloatArray) -> None:
    mesh = extrude([polygon(corners)])
    outwards = mesh.vertices[mesh.triangles].mean(axis=1) - mesh.vertices.mean(axis=0)
    assert (np.einsum("ij,ij->i", normals(mesh), outwards) > 0).all()


@given(length=st.floats(0.01, 50.0), width=st.floats(0.01, 50.0), yaw=st.floats(-4.0, 4.0), x=st.floats(-50.0, 50.0))
def test_the_volume_is_area_times_height(length: float, width: float, yaw: float, x: float) -> None:
    mesh = extrude([Prism(rectangle((x, 1.0), length, width, yaw), 0.0, 1.5)])
    assert volume(mesh) == pytest.approx(length * width * 1.5, rel=1e-6, abs=1e-6)


def test_many_prisms_keep_their_own_surfaces() -> None:
    things = [
        Wall(points=((0, 0), (4, 0), (4, 3)), closed=True),
        Table(center=(2, 1)),
        Box(center=(1, 1), size=(1, 2, 3)),
    ]
    prisms = [prism for thing in things for prism in thing.prisms()]
    mesh = extrude(prisms)
    assert mesh.vertices.shape == (len(prisms) * 8, 3)
    assert (np.bincount(mesh.triangles.ravel() // 8) == 36).all()
    assert volume(mesh) == pytest.approx(sum(volume(extrude([prism])) for prism in prisms))


def test_an_empty_plan_gives_an_empty_mesh() -> None:
    mesh = extrude([])
    assert mesh.vertices.shape == mesh.triangles.shape == (0, 3)
