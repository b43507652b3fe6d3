"""Predictions and comparisons equal the command's."""

import json

import numpy as np
import pytest

import machband


@pytest.mark.parametrize(
    "given", [{}, {"width": 0.1, "depth": 3}, {"kind": "kanizsa"}, {"orientation_deg": 45}, {"kind": "shaded-mesh"}]
)
def test_a_stimulus_has_the_commands_prediction(command, given):
    kind = given.get("kind", "mach-band")
    rest = {name: value for name, value in given.items() if name != "kind"}
    words = [f"--{name.removesuffix('_deg')}={value}" for name, value in rest.items()]
    told = json.loads(command("predict", "--kind", kind, *words, "--window", 8, "--json"))
    found = machband.predict(kind, window_deg=8, **rest)
    for name in ["band_bright", "band_dark", "detection", "difference"]:
        expected = told.get(name)
        assert getattr(found, name) == (expected if expected is None else pytest.approx(expected, abs=6e-5))
    assert found.predicted_rating is None
    if kind == "mach-band":
        bright, dark = found.at_deg
        assert dark < 0 < bright and found.blur_deg > 0


def test_a_criterion_predicts_ratings(tmp_path):
    (tmp_path / "lab.toml").write_text("schema = 1\nthresholds = [0.5, 1.0, 2.0]\nspread = 0.5\n")
    ratings = [machband.predict(width=0.1, depth=n, criterion=tmp_path / "lab.toml").predicted_rating for n in (1, 2, 3)]
    assert 3 > ratings[0] > ratings[1] > ratings[2] > 0


@pytest.mark.parametrize("bits", [8, 16])
def test_pictures_have_the_commands_difference(command, tmp_path, bits):
    codes = [machband.stimulus(width=0.1, depth=depth, size=200, bits=bits) for depth in (1, 3)]
    for name, depth in [("a.png", 1), ("b.png", 3)]:
        command("stimulus", "--width", 0.1, "--depth", depth, "--size", 200, "--bits", bits, "--out", name)
    told = json.loads(command("compare", "a.png", "b.png", "--window", 5, "--json"))
    of_files = machband.compare(tmp_path / "a.png", str(tmp_path / "b.png"), window_deg=5)
    found = machband.compare(*codes, ppd=40)
    for one in [of_files, found]:
        assert one.times_threshold == pytest.approx(told["times_threshold"], rel=1e-9)
        assert one.center == pytest.approx(told["center"], rel=1e-9)
        assert [list(place) for place in one.places] == [list(place.values()) for place in told["places"]]
    assert found.map.shape == (200, 200) and found.map.max() <= found.times_threshold
    place = found.places[0]
    assert found.map[place.y, place.x] == pytest.approx(found.times_threshold, rel=0.05)
    assert "map" not in repr(found) and "sRGB" in of_files.light


def test_light_gray_and_strided_pictures():
    codes = machband.stimulus("kanizsa", size=128, color="gray", bits=16)
    dim = codes // 2
    wide = np.zeros((128, 256, 3), np.uint16)
    wide[:, ::2] = codes
    light, other = (machband.Transfer().decode(image / 65535) for image in (codes, dim))
    with pytest.warns(UserWarning, match="mean luminance"):
        expected = machband.compare(codes, dim, window_deg=5).times_threshold
        assert machband.compare(codes[:, :, 0], dim[:, :, 0], window_deg=5).times_threshold == expected
        assert machband.compare(wide[:, ::2], dim.astype(">u2"), window_deg=5).times_threshold == expected
        of_light = machband.compare(np.asfortranarray(light.astype(np.float32)), other, window_deg=5)
    assert of_light.times_threshold == pytest.approx(expected, rel=1e-4)
    assert machband.compare(codes, codes, window_deg=5).times_threshold == 0


def test_steps_are_those_of_the_command(command, tmp_path):
    codes = np.repeat(np.linspace(118, 128, 400).astype(np.uint8)[np.newaxis, :], 60, axis=0)
    found = machband.steps(codes, window_deg=16)
    assert found.steps > found.dithered > 0 and found.picture.shape == (60, 400, 3) and found.rounded is None
    fine = np.repeat(np.linspace(118 * 257, 128 * 257, 400).astype(np.uint16)[np.newaxis, :], 60, axis=0)
    of_fine = machband.steps(fine, window_deg=16)
    assert of_fine.rounded == pytest.approx(found.steps, rel=0.1) and of_fine.steps < 0.1 < of_fine.dithered
    command("stimulus", "--width", 0.9, "--low", 0.2, "--high", 0.22, "--size", 200, "--out", "slow.png")
    told = json.loads(command("compare", "slow.png", "--steps", "--window", 20, "--json"))
    with pytest.raises(machband.Error, match="missing.png"):
        machband.compare("missing.png", tmp_path / "slow.png", window_deg=4)
    of_file = machband.steps(tmp_path / "slow.png", window_deg=20)
    assert [of_file.steps, of_file.dithered] == pytest.approx([told["steps"], told["dithered"]])
    with pytest.raises(ValueError, match="transfer is for codes, and floats are light"):
        machband.compare(codes / 255, codes / 255, window_deg=20, transfer="srgb")
    with pytest.raises(ValueError, match="picture is light, which has no codes"):
        machband.steps(codes / 255, window_deg=16)


OK = np.ones((64, 64), np.uint8)


@pytest.mark.parametrize(
    ("image", "given", "error", "words"),
    [
        (np.zeros((8, 8, 4)), {}, ValueError, r"shape \(8, 8, 4\)"),
        (np.zeros((0, 8, 3)), {}, ValueError, "at least one pixel"),
        (np.zeros((64, 64), int), {}, TypeError, "dtype int64"),
        (np.zeros((64, 64)), {"black": 0}, machband.Error, "no light"),
        (np.full((64, 64), np.nan), {}, machband.Error, "nan"),
        (np.full((64, 64), -0.5), {}, machband.Error, "light -0.5 in row 0, column 0; expected 0 to 1"),
        (np.ones((32, 64)), {}, machband.Error, "64 × 32 pixels"),
        (OK, {"window_deg": 0}, machband.Error, "window_deg 0"),
        (OK, {"window_deg": None}, machband.Error, "window_deg is missing; expected the width .*, or ppd"),
        (OK, {"ppd": 1}, machband.Error, "'window_deg' cannot be used with 'ppd'"),
        (OK, {"pdd": 32}, TypeError, "did you mean 'ppd'"),
        (np.full((64, 64), 255.0), {}, ValueError, "0 to 1"),
        ("missing.png", {}, TypeError, "two paths or two arrays"),
        (np.ma.masked_less(np.ones((64, 64)), 0.5), {}, TypeError, "masked"),
        ({"img": 1}, {}, TypeError, "picture is dict"),
    ],
)
def test_wrong_pictures_are_refused(image, given, error, words):
    with pytest.raises(error, match=words):
        machband.compare(image, OK, **{"window_deg": 4, **given})


@pytest.mark.parametrize(
    ("given", "error", "words"),
    [
        ({"size": 4}, machband.Error, "size 4"),
        ({"ppd": 1, "window_deg": 1}, machband.Error, "cannot be used with"),
        ({"ppd": np.inf}, machband.Error, "ppd inf"),
        ({"kind": machband.stimuli.chevreul(size=8)}, TypeError, "kind is Stimulus.'chevreul'.*expected text"),
        ({"criterion": "missing.toml"}, machband.Error, "missing.toml"),
    ],
)
def test_wrong_predictions_are_refused(given, error, words):
    with pytest.raises(error, match=words):
        machband.predict(**given)
