"""Shaded meshes equal the command's."""

import json

import numpy as np
import pytest

import machband


def test_a_shape_equals_the_commands(command, image, tmp_path):
    words = ["--mesh", "torus", "--vertices", 200, "--shader", "patch", "--size", 160, "--rotate", "10,20,30"]
    command("shade", *words, "--out", "image.png", "--metrics", "metrics.json")
    found = machband.shade("torus", n_vertices=200, shader="patch", size=160, rotate=(10, 20, 30))
    assert np.array_equal(found.image, image("image.png"))
    assert found.metrics == json.loads((tmp_path / "metrics.json").read_text())


def test_arrays_equal_the_shape_that_they_came_from():
    mesh = machband.mesh("torus", n_vertices=200)
    assert mesh.vertices.shape == mesh.normals.shape == (mesh.vertices.shape[0], 3)
    assert np.allclose(np.linalg.norm(mesh.normals, axis=1), 1)
    for shader in ["flat", "gouraud", "phong", "c1-phong", "patch"]:
        measure = shader == "c1-phong"
        named = machband.shade("torus", n_vertices=200, shader=shader, size=128, metrics=measure)
        arrays = machband.shade(*mesh, shader=shader, size=128, metrics=measure)
        assert np.array_equal(named.image, arrays.image)
        if measure:
            assert arrays.metrics["crease_rms"] == pytest.approx(named.metrics["crease_rms"], abs=1e-9)
            # The arrays do not say which surface they approximate.
            assert arrays.metrics["residual"] is None and named.metrics["residual"] is not None


def test_the_picture_turns_with_the_mesh():
    vertices, triangles, normals = machband.mesh("blob", n_vertices=100)
    turned = np.array([[0, -1, 0], [1, 0, 0], [0, 0, 1.0]])
    light = np.array([0.36, 0.48, 0.8])
    one = machband.shade(vertices, triangles, normals, rotate=(0, 0, 0), light=light, size=129, metrics=False)
    other = machband.shade(
        vertices @ turned.T, triangles, normals @ turned.T, rotate=(0, 0, 0), light=turned @ light, size=129, metrics=False
    )
    different = (np.abs(np.rot90(one.image).astype(int) - other.image) > 1).any(axis=2)
    assert one.metrics is None and different.mean() < 0.02


def test_truth_and_estimated_normals():
    smooth = machband.shade("sphere", shader=None, truth=True, size=128)
    assert smooth.metrics is None
    drawn = machband.shade("sphere", n_vertices=2000, size=128, metrics=False)
    assert np.abs(smooth.image.astype(int) - drawn.image).mean() < 1
    mesh = machband.mesh("blob")
    plain = machband.shade(mesh.vertices, mesh.triangles, size=128).metrics
    best = machband.shade(mesh.vertices, mesh.triangles, "best", size=128).metrics
    assert plain["normals"] == "averaged" and best["normals"] == "best" and plain["vertices"] == 313


def test_a_scene_of_several_meshes(command, image, tmp_path):
    scene = tmp_path / "scene.toml"
    from conftest import ROOT

    scene.write_text((ROOT.parent / "examples" / "scenes" / "glass.toml").read_text())
    for more in [{}, {"dither": "random", "seed": 3}]:
        command("shade", "scene.toml", "--size", 96, "--out", "image.png", "--force", *(f"--{k}={v}" for k, v in more.items()))
        assert np.array_equal(machband.shade(scene, size=96, **more).image, image("image.png"))
    for other in [{"shader": "flat"}, {"rotate": (0, 0, 0)}, {"truth": True}, {"n_vertices": 9}]:
        with pytest.raises(machband.Error, match="does not apply to a scene; expected keys in its file"):
            machband.shade(scene, **other)


TRIANGLE = ([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])


def test_a_repaired_mesh_is_a_warning():
    vertices = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]]
    with pytest.warns(UserWarning, match="reversed 1 face"):
        machband.shade(vertices, [[0, 1, 2], [1, 2, 3]], rotate=(0, 0, 0), size=64, metrics=False)


@pytest.mark.parametrize(
    ("args", "given", "error", "words"),
    [
        (([[0, 0]], [[0, 0, 0]]), {}, ValueError, "vertices has shape"),
        (([[0, 0, 0]], [[0, 0, 0]]), {}, machband.Error, "area"),
        ((TRIANGLE[0], [[0, 1, 3]]), {}, machband.Error, "refers to vertex 3"),
        ((TRIANGLE[0], [[0, 1, -1]]), {}, ValueError, "negative"),
        ((TRIANGLE[0], [[0.5, 1, 2]]), {}, ValueError, "fraction"),
        ((TRIANGLE[0], np.zeros((0, 3), int)), {}, machband.Error, "at least one triangle"),
        (([[0, 0, np.nan], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]]), {}, machband.Error, "not finite"),
        ((*TRIANGLE, [[0, 0, 1]]), {}, ValueError, "one for each vertex"),
        ((*TRIANGLE, [[0, 0, 1], [0, 0, 0], [0, 0, 1]]), {}, machband.Error, "normal 1 is zero"),
        ((*TRIANGLE, np.full((3, 3), np.nan)), {}, machband.Error, "normal 0 is zero or not finite"),
        (TRIANGLE, {"normals": "given"}, TypeError, "for files; expected an array"),
        (TRIANGLE, {"normals": "mean"}, machband.Error, "given, averaged, best"),
        (TRIANGLE, {"n_vertices": 9}, TypeError, "n_vertices for arrays"),
        ((TRIANGLE[0],), {}, TypeError, "without triangles"),
        (TRIANGLE, {"shader": "gourad"}, machband.Error, "gouraud"),
        (TRIANGLE, {"shadr": "flat"}, TypeError, "did you mean 'shader'"),
        (TRIANGLE, {"boundary": 2}, machband.Error, "outside 0…1"),
        (TRIANGLE, {"rotate": (90, 0, 0)}, machband.Error, "faces the viewer"),
        (TRIANGLE, {"truth": True, "shader": None}, machband.Error, "not known"),
        (("sphere",), {"truth": True}, machband.Error, "draws the smooth surface itself"),
        (("blob", [[0, 1, 2]]), {}, TypeError, "triangles"),
        ((machband.mesh("cube"), [[0, 1, 2]]), {}, TypeError, "expected a Mesh alone"),
        (("blob",), {"shader": None}, TypeError, "neither shader nor truth"),
        (("blobb",), {}, machband.Error, "did you mean 'blob'"),
        (("blob",), {"truth": 1}, TypeError, "truth is 1; expected a path"),
        ((np.ma.masked_less(TRIANGLE[0], 1), TRIANGLE[1]), {}, TypeError, "vertices is a masked array"),
    ],
)
def test_wrong_meshes_are_refused(args, given, error, words):
    with pytest.raises(error, match=words):
        machband.shade(*args, **{"size": 32, **given})
