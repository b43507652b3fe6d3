"""Predictions equal the command's."""

import json

import numpy as np
import pytest

import machband


@pytest.mark.parametrize("given", [{}, {"width": 0.1, "depth": 3}, {"kind": "kanizsa"}, {"orientation_deg": 45}])
def test_a_stimulus_has_the_commands_prediction(command, given):
    kind = given.get("kind", "mach-band")
    rest = {name: value for name, value in given.items() if name != "kind"}
    words = [f"--{name.removesuffix('_deg')}={value}" for name, value in rest.items()]
    told = json.loads(command("predict", "--kind", kind, *words, "--window", 8, "--json"))
    found = machband.predict(kind, window_deg=8, **rest)
    for name in ["visibility", "detection", "predicted_rating"]:
        assert getattr(found, name) == pytest.approx(told[name], abs=6e-5)
    assert (found.along is None) == (found.map is not None)
    if found.along:
        assert found.along[0].visibility == pytest.approx(found.visibility) and "map" not in repr(found)


@pytest.mark.parametrize("bits", [8, 16])
def test_an_image_has_the_commands_prediction(command, tmp_path, bits):
    codes = machband.stimulus("vasarely", size=200, bits=bits)
    command("stimulus", "--kind", "vasarely", "--size", 200, "--bits", bits, "--out", "image.png")
    told = json.loads(command("predict", "--image", "image.png", "--window", 5, "--json"))
    of_file = machband.predict(tmp_path / "image.png", window_deg=5)
    assert of_file.visibility == machband.predict(str(tmp_path / "image.png"), ppd=40).visibility
    found = machband.predict(codes, window_deg=5)
    assert found.visibility == pytest.approx(told["visibility"], abs=6e-5)
    assert found.bands == pytest.approx((told["visibility_bright"], told["visibility_dark"]), abs=6e-5)
    assert found.lines == pytest.approx((told["lines_bright"], told["lines_dark"]), abs=6e-5)
    # The map's strongest places are the visibility, apart from the interpolation between pixels.
    assert found.map[0].shape == (200, 200)
    assert found.map[0].max() == pytest.approx(found.bands[0], rel=0.1)
    assert machband.predict(codes, ppd=40).visibility == found.visibility


def test_light_gray_and_strided_images():
    codes = machband.stimulus("kanizsa", size=128, color="gray", bits=16)
    expected = machband.predict(codes).visibility
    assert machband.predict(codes[:, :, 0]).visibility == expected
    wide = np.zeros((128, 256, 3), np.uint16)
    wide[:, ::2] = codes
    assert machband.predict(wide[:, ::2]).visibility == expected
    assert machband.predict(codes.astype(">u2")).visibility == expected
    light = machband.transfer(codes / 65535, inverse=True)
    assert machband.predict(light).visibility == pytest.approx(expected, rel=1e-5)
    assert machband.predict(np.asfortranarray(light.astype(np.float32))).visibility == pytest.approx(expected, rel=1e-5)


def test_a_display_profile_says_what_codes_mean(command, tmp_path):
    levels = [0, 0.2, 0.4, 0.6, 0.8, 1]
    lines = [f"gray,{level},{0.3 + 250 * level**1.8}" for level in levels]
    (tmp_path / "readings.csv").write_text("\n".join(["channel,level,luminance_cd_m2", *lines]) + "\n")
    command("calibrate", "readings.csv", "--out", "profile.toml")
    codes = machband.stimulus("vasarely", size=128)
    command("stimulus", "--kind", "vasarely", "--size", 128, "--out", "image.png")
    told = json.loads(command("predict", "--image", "image.png", "--display", "profile.toml", "--json"))
    found = machband.predict(codes, display=tmp_path / "profile.toml")
    assert found.visibility == pytest.approx(told["visibility"], abs=6e-5)
    assert found.visibility != machband.predict(codes).visibility


@pytest.mark.parametrize(
    ("image", "given", "error", "words"),
    [
        (np.zeros((8, 8, 4)), {}, ValueError, r"shape \(8, 8, 4\)"),
        (np.zeros(8), {}, ValueError, "shape"),
        (np.zeros((0, 8, 3)), {}, ValueError, "at least one pixel"),
        (np.zeros((64, 64), int), {}, TypeError, "dtype int64"),
        (np.zeros((64, 64)), {}, machband.Error, "black"),
        (np.full((64, 64), np.nan), {}, machband.Error, "NaN"),
        (np.full((64, 64), -0.5), {}, machband.Error, "negative"),
        (np.ones((64, 64)), {"window_deg": 0}, machband.Error, "window_deg 0"),
        (np.ones((64, 64)), {"ppd": np.inf}, machband.Error, "ppd inf"),
        (np.ones((64, 64)), {"ppd": 1, "window_deg": 1}, TypeError, "one of them"),
        (np.ones((64, 64)), {"width": 1}, TypeError, "width"),
        (np.ones((64, 64)), {"pdd": 32}, TypeError, "did you mean 'ppd'"),
        (np.ones((64, 64)), {"ppd": (32, 32)}, TypeError, "ppd is"),
        (np.full((64, 64), 255.0), {}, ValueError, "0 to 1"),
        ("missing.png", {}, machband.Error, "missing.png"),
        ("photo.jpg", {}, machband.Error, "photo.jpg: cannot be opened"),
        (np.ma.masked_less(np.ones((64, 64)), 0.5), {}, TypeError, "masked"),
        ({"img": 1}, {}, TypeError, "dict is no picture"),
        (np.ones((64, 64)), {"transfer": "srgb"}, TypeError, "linear light"),
        (np.ones((4000, 4000), np.uint8), {}, ValueError, "the option large"),
        ("mach-band", {"widht": 1}, machband.Error, "did you mean width"),
        ("mach-band", {"size": 4}, machband.Error, "size 4"),
    ],
)
def test_wrong_images_are_refused(image, given, error, words):
    with pytest.raises(error, match=words):
        machband.predict(image, **given)
