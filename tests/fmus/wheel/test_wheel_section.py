"""Cross-sections: what is refused, and that the mesh fills the outline."""

from __future__ import annotations

import dataclasses
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from skfem import MeshQuad2

from fmus.wheel.finite_elements.mesh import mesh_section
from fmus.wheel.finite_elements.section import Material, Section, read_section
from fmus.wheel.wheelset import DATA

SECTION_FILE = DATA / "generic840-section.toml"
GENERIC = read_section(SECTION_FILE)


def polygon_area(points: NDArray[np.float64]) -> float:
    z, r = points.T
    return float(abs(np.sum(z[:-1] * r[1:] - z[1:] * r[:-1])) / 2)


@pytest.mark.parametrize("name", ["generic840", "straight840"])
def test_mesh_covers_the_outline(name: str) -> None:
    """Two routes to the area: the polygon of the outline, and the mesh.

    The web's faces are second-order curves through five points per fillet length at the coarsest; refined twice, mesh
    and a polygon of 200 sides agree to 1e-4.
    """
    section = read_section(DATA / f"{name}-section.toml")
    cut = mesh_section(section, 2)
    area = _mesh_area(cut.mesh)
    assert area == pytest.approx(sum(polygon_area(line) for line in section.outline()), rel=1e-4)


def _mesh_area(mesh: MeshQuad2) -> float:
    points, weights = np.polynomial.legendre.leggauss(3)
    X = np.stack([axis.ravel() for axis in np.meshgrid((points + 1) / 2, (points + 1) / 2)])
    return float(mesh.mapping().detDF(X).sum(axis=0) @ np.outer(weights, weights).ravel() / 4)


def test_contact_point_is_a_vertex() -> None:
    """The contact point is found in the mesh, not interpolated."""
    mesh = mesh_section(GENERIC).mesh
    point = np.array([[GENERIC.contact_position], [GENERIC.contact_radius]])
    assert np.linalg.norm(mesh.p - point, axis=0).min() < 1e-9


def test_refinement_keeps_every_vertex() -> None:
    """The mesh cut 2 x 2 contains the vertices of the coarsest one, so that its functions contain those of it."""
    coarse, fine = mesh_section(GENERIC, 1).mesh.p, mesh_section(GENERIC, 2).mesh.p
    distance = np.abs(coarse[:, :, None] - fine[:, None, :]).max(axis=0).min(axis=1)
    assert distance.max() < 1e-9


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"rim_inner_radius": 0.43}, "outline intersects itself: radii of seat, hub, rim inside and running profile"),
        ({"hub_radius": 0.37}, "outline intersects itself: radii of seat"),
        ({"hub_faces": (0.74, 0.835)}, "outline intersects itself: the web meets the hub"),
        ({"hub_faces": (0.835, 0.665)}, "hub faces at 0.835 and 0.665 m; must rise"),
        (
            {"profile": ((0.68, 0.43), (0.70, 0.448), (0.69, 0.42), (0.815, 0.417))},
            "z of the running profile must increase",
        ),
        ({"axle": ((0.0, -0.07), (1.1, 0.0875))}, "r of the axle must be > 0"),
        ({"axle": ((0.1, 0.0875), (1.1, 0.0875))}, "axle starts at z = 0.1 m; must start at mid-axle"),
        ({"axle": ((0.0, 0.07), (0.75, 0.08), (1.1, 0.09))}, "the seat must be a cylinder"),
        ({"contact_radius": 0.41}, "the contact point z = 0.75, r = 0.41 m is not on the running profile"),
        ({"rim_inner_radius": float("nan")}, "a dimension is not finite"),
    ],
)
def test_geometry_that_intersects_itself_is_refused(change: dict[str, Any], message: str) -> None:
    """One sentence says where."""
    with pytest.raises(ValueError, match=re.escape(message)):
        dataclasses.replace(GENERIC, **change)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"hub_thickness": -0.04}, "the faces of the web cross"),
        ({"rim_position": 0.70}, "the web meets the rim"),
        ({"rim_thickness": 0.1}, "the web meets the rim"),
        ({"fillet_length": 0.0}, "fillet_length = 0; must be > 0"),
    ],
)
def test_a_web_that_does_not_fit_is_refused(change: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        dataclasses.replace(GENERIC, web=dataclasses.replace(GENERIC.web, **change))


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ((0.0, 0.3, 7850.0), "young_modulus = 0; must be finite and > 0"),
        ((210e9, 0.5, 7850.0), "poisson_ratio = 0.5; must be between -1 and 0.5"),
        ((210e9, 0.3, float("inf")), "density = inf"),
    ],
)
def test_an_impossible_material_is_refused(values: tuple[float, float, float], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        Material(*values)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("inner_radius_m = 0.3647", "", "'inner_radius_m' is missing"),
        ("inner_radius_m = 0.3647", "inner_radius_m = 'wide'", "every dimension must be a number"),
        ("inner_radius_m = 0.3647", "inner_radius_m = 0.5", "the outline intersects itself"),
        ("title =", "name =", "'title' is missing"),
        ("title =", "title", "Expected '='"),
        ("faces_m = [0.665, 0.835]", "faces_m = [0.665]", "must be a pair of numbers"),
    ],
)
def test_a_bad_file_is_refused_with_its_name(tmp_path: Path, old: str, new: str, message: str) -> None:
    text = SECTION_FILE.read_text(encoding="utf-8")
    assert old in text
    path = tmp_path / "bad-section.toml"
    path.write_text(text.replace(old, new), encoding="utf-8")
    with pytest.raises(ValueError, match=rf"bad-section.toml: .*{message}"):
        read_section(path)


def test_the_straight_web_is_the_curved_one_without_its_curve() -> None:
    """The two shipped sections differ in the web's centre line only."""
    straight = read_section(DATA / "straight840-section.toml")
    web = GENERIC.web
    same = dataclasses.replace(
        straight.web, rim_position=web.rim_position, hub_position=web.hub_position, bulge=web.bulge
    )
    assert dataclasses.replace(straight, title=GENERIC.title, web=same) == GENERIC
    np.testing.assert_array_equal(straight.web.centre(np.linspace(0, 1, 5)), straight.web.rim_position)


def test_refinement_must_be_positive() -> None:
    with pytest.raises(ValueError, match="refinement = 0; must be >= 1"):
        mesh_section(GENERIC, 0)


def test_sections_are_values() -> None:
    """Equal files make equal, hashable sections."""
    assert isinstance(GENERIC, Section)
    assert hash(read_section(SECTION_FILE)) == hash(GENERIC)
