"""Stimuli equal the command's images, and the functions behind them have the properties that mathematics gives them."""

import csv
import io
import math

import numpy as np
import pytest

import machband


@pytest.mark.parametrize(
    ("words", "given"),
    [
        ([], {}),
        (["--width", 0.1, "--depth", "inf", "--orientation", 30], {"width": 0.1, "depth": math.inf, "orientation_deg": 30}),
        (["--kind", "vasarely", "--bits", 16], {"kind": "vasarely", "bits": 16}),
        (["--kind", "kanizsa", "--transfer", "gamma:2.2"], {"kind": "kanizsa", "transfer": "gamma:2.2"}),
        (["--kind", "shaded-mesh"], {"kind": "shaded-mesh"}),
        (["--dither", "random", "--seed", 9], {"dither": "random", "seed": 9}),
        (["--color", "1,0.5,0", "--dither", "blue-noise"], {"color": (1, 0.5, 0), "dither": "blue-noise"}),
    ],
)
def test_an_array_equals_the_commands_image(command, image, words, given):
    command("stimulus", "--size", 96, *words, "--out", "image.png")
    codes = machband.stimulus(size=96, **given)
    assert np.array_equal(image("image.png"), codes)
    assert codes.shape == (96, 96, 3)
    assert codes.dtype == (np.uint16 if given.get("bits") == 16 else np.uint8)
    assert codes.flags.writeable and codes.flags.c_contiguous


def test_a_profile_equals_the_commands_table(command, tmp_path):
    command("stimulus", "--size", 64, "--depth", 3, "--bits", 16, "--profile", "profile.csv")
    rows = list(csv.DictReader(io.StringIO((tmp_path / "profile.csv").read_text())))
    found = machband.profile(size=64, depth=3, bits=16)
    assert list(found) == list(rows[0])
    for name in rows[0]:
        assert found[name].tolist() == [float(row[name]) for row in rows]


def test_light_and_codes_agree():
    light = machband.light(size=64, width=0.5, depth=2)
    assert light.dtype == np.float32 and light.shape == (64, 64, 3)
    encoded = machband.transfer(light)
    assert np.abs(machband.stimulus(size=64, width=0.5, depth=2) / 255 - encoded).max() <= 0.5 / 255 + 1e-6


def test_every_kind_and_parameter_is_described():
    for kind, about in machband.kinds().items():
        assert about
        for name, parameter in machband.parameters(kind).items():
            assert parameter.name == name and parameter.description and parameter.expected
            # The defaults can be given back.
            machband.light(kind, size=32, **{name: parameter.default})


def test_the_dict_is_like_stimupys():
    found = machband.stimulus(size=200, color="gray", width=0.5, as_dict=True, window_deg=8)
    assert found["visual_size"] == (8, 8) and found["ppd"] == (25, 25) and found["shape"] == (200, 200)
    assert np.array_equal(found["img"], machband.stimulus(size=200, color="gray", width=0.5))
    assert found["width"] == 0.5 and found["low"] == 0.25
    # A dark plateau, a ramp, and a bright plateau.
    row = found["mask"][100]
    assert row[0] == 1 and row[100] == 0 and row[-1] == 2
    assert (found["mask"] == row).all()
    steps = machband.stimulus("chevreul", size=200, as_dict=True)["mask"]
    assert np.unique(steps).tolist() == list(range(1, steps.max() + 1)) and steps.max() > 2


def test_interpolation_is_monotone_and_symmetric():
    u = np.linspace(-0.2, 1.2, 1401)
    for depth in [*range(1, 33), "inf"]:
        found = machband.interpolate(u, depth)
        assert (np.diff(found) >= 0).all() and found[0] == 0 and found[-1] == 1
        inside = (u > 1e-9) & (u < 1 - 1e-9)
        assert np.abs(found + machband.interpolate(1 - u, depth) - 1)[inside].max() < 1e-12
    # The second depth is the cubic that has no slope at its ends.
    assert np.allclose(machband.interpolate(u.clip(0, 1), 2), 3 * u.clip(0, 1) ** 2 - 2 * u.clip(0, 1) ** 3)


def test_scalars_shapes_and_strides():
    assert isinstance(machband.interpolate(0.5), float)
    grid = np.random.default_rng(1).random((6, 8))
    assert machband.interpolate(grid).shape == (6, 8)
    for view in [grid[::2, ::-3], grid.T, np.asfortranarray(grid), grid.astype(np.float32), grid.tolist()]:
        expected = np.asarray(view, float)
        assert np.allclose(machband.interpolate(view, 1), expected)
        assert np.allclose(machband.transfer(machband.transfer(view), inverse=True), expected)
    assert math.isnan(machband.interpolate(math.nan))
    assert machband.interpolate([]).shape == (0,)


def test_srgb_is_the_standards():
    light = np.linspace(0, 1, 257)
    # IEC 61966-2-1.
    expected = np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055)
    assert np.abs(machband.transfer(light) - expected).max() < 1e-6


def test_visual_angle_is_trigonometry():
    cm = np.array([[0.5, 1.0], [10.0, 40.0]])
    found = machband.visual_angle(cm=cm, screen_px=2560, screen_cm=60, distance_cm=70)
    assert np.allclose(found.deg, 2 * np.degrees(np.arctan(cm / 140)))
    assert np.allclose(found.px, cm * 2560 / 60)
    back = machband.visual_angle(deg=found.deg, screen_px=2560, screen_cm=60, distance_cm=70)
    assert np.allclose(back.px, found.px)
    with pytest.raises(TypeError, match="exactly one"):
        machband.visual_angle(px=1, deg=1, screen_px=2560, screen_cm=60, distance_cm=70)
    with pytest.raises(machband.Error, match="10…2000"):
        machband.visual_angle(px=1, screen_px=2560, screen_cm=60, distance_cm=1)


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"widht": 0.2}, "did you mean width"),
        ({"kind": "mach-bnd"}, "did you mean mach-band"),
        ({"size": 0}, "size 0"),
        ({"size": 20000}, "16384"),
        ({"bits": 12}, "expected one of 8, 16"),
        ({"width": math.nan}, "not a finite number"),
        ({"seed": -1}, "seed -1"),
        ({"as_dict": True, "window_deg": 0}, "window_deg"),
        ({"depth": 2.5}, "whole number"),
        ({"low": 0.9, "high": 0.1}, "below low"),
        ({"color": "bleu"}, "bleu"),
        ({"dither": "none!"}, "dither|expected none"),
        ({"transfer": "srgb", "display": "x.toml"}, "exclude"),
        ({"display": "missing.toml"}, "missing.toml"),
    ],
)
def test_wrong_values_are_named(given, words):
    with pytest.raises(machband.Error, match=words) as caught:
        machband.stimulus(**{"size": 32, **given})
    assert isinstance(caught.value, ValueError) and "expected" in str(caught.value)


@pytest.mark.parametrize("given", [{"size": "big"}, {"size": 3.5}, {"width": None}, {"width": [[1]]}, {"kind": None}, {"size": True}, {"as_dict": "no"}, {"transfer": 2.2}])
def test_wrong_types_are_refused(given):
    with pytest.raises(TypeError, match="expected"):
        machband.stimulus(**{"size": 32, **given})


def test_encoded_values_and_angles_have_limits():
    for values in [[-0.1], [1.1], np.uint8([0, 128]), [math.nan]]:
        with pytest.raises(machband.Error, match="expected 0 to 1"):
            machband.transfer(values)
    with pytest.raises(machband.Error, match="less than 180"):
        machband.visual_angle(deg=180, screen_px=2560, screen_cm=60, distance_cm=70)


def test_wrong_keywords_are_named():
    with pytest.raises(TypeError, match="did you mean 'depth'"):
        machband.interpolate(0.5, dpeth=2)
