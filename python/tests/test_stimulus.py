"""Stimuli equal the command's images, and the functions behind them have the properties that mathematics gives them."""

import csv
import io
import math
import pickle

import numpy as np
import pytest

import machband
from conftest import needs


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
    encoded = machband.Transfer().encode(light)
    assert np.abs(machband.stimulus(size=64, width=0.5, depth=2) / 255 - encoded).max() <= 0.5 / 255 + 1e-6


def test_every_kind_and_parameter_is_described():
    for kind, about in machband.kinds().items():
        assert about
        for name, parameter in machband.parameters(kind).items():
            assert parameter.name == name and parameter.description and parameter.expected
            # The defaults can be given back.
            machband.light(kind, size=32, **{name: parameter.default})


def test_a_stimulus_is_an_object(command, image, tmp_path):
    made = machband.stimuli.mach_band(width=0.5, color="gray", ppd=25, visual_size=8)
    assert (made.shape, made.ppd, made.visual_size) == ((200, 200), (25, 25), (8, 8))
    assert np.array_equal(np.asarray(made), machband.light(size=200, width=0.5, color="gray"))
    assert np.asarray(made, np.float64).dtype == np.float64 and not made.light.flags.writeable
    with pytest.raises(ValueError, match="avoid copy"):
        np.asarray(made, np.float64, copy=False)
    for again in [machband.stimuli.mach_band(**made.parameters), pickle.loads(pickle.dumps(made)), eval(repr(made), vars(machband))]:
        assert again == made != machband.stimuli.mach_band(size=200)
    coding = {"bits": 16, "dither": "random", "seed": 9, "transfer": machband.Transfer.gamma(2.2)}
    command("stimulus", "--size", 200, "--width", 0.5, "--color", "gray", "--bits", 16, "--dither", "random", "--seed", 9,
            "--transfer", "gamma:2.2", "--out", "told.png")
    made.save(tmp_path / "ours.png", **coding)
    assert (tmp_path / "ours.png").read_bytes() == (tmp_path / "told.png").read_bytes()
    assert np.array_equal(made.codes(**coding), image("told.png"))
    with pytest.raises(machband.Error, match="ours.png: already exists"):
        made.save(tmp_path / "ours.png")
    assert made.profile()["linear"].equals(machband.profile(size=200, width=0.5, color="gray")["linear"])
    assert made.predict() == machband.predict(size=200, width=0.5, color="gray", window_deg=8)


def test_stimupy_and_matplotlib_draw_it(monkeypatch):
    needs("stimupy"), needs("matplotlib")
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot
    from stimupy.utils import plot_stim

    monkeypatch.setattr(pyplot, "show", lambda: None)
    made = machband.stimuli.cornsweet(color="yellow", size=64)
    given = made.to_stimupy()
    assert given["img"].shape == (64, 64) and given["img"].dtype == float and given["img"].max() <= 1
    plot_stim(given)
    axes = made.plot()
    assert axes.images[0].get_extent() == [-5, 5, -5, 5] and made._repr_png_().startswith(b"\x89PNG")


def test_a_stimulus_can_be_a_rectangle(tmp_path):
    square, made = (machband.stimuli.vasarely(size=size, visual_size=8) for size in (200, (101, 200)))
    assert (made.shape, made.ppd, made.visual_size) == ((101, 200), (25, 25), (4.04, 8))
    assert made == machband.stimuli.vasarely(ppd=25, visual_size=(4.04, 8)) != square
    assert made == pickle.loads(pickle.dumps(made)) == eval(repr(made), vars(machband))
    for whole, part in [(square.light, made.light), (square.codes(dither="ordered"), made.codes(dither="ordered"))]:
        assert np.array_equal(part, whole[49:150])
    assert made.to_stimupy()["img"].shape == (101, 200)
    assert np.allclose(made.plot().images[0].get_extent(), [-4, 4, -2.02, 2.02])
    for square_alone in [made.predict, lambda: made.save(tmp_path / "a.png")]:
        with pytest.raises(machband.Error, match="expected a square"):
            square_alone()


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"ppd": 3, "visual_size": 2.1}, "whole pixels"), ({"ppd": -3}, "ppd is -3; expected a number above 0"),
        ({"size": 10, "ppd": 3, "visual_size": 3}, "ppd times visual_size is 9.0, size 10; expected whole pixels, and no size or the same"),
        ({"size": (10, 20), "ppd": 3, "visual_size": 5}, "is 15.0"), ({"size": (1, 2, 3)}, "height and width"),
        ({"ppd": 1e9, "visual_size": 5}, "ppd times visual_size 5000000000 is outside 1…16384"),
        ({"size": (10, 20), "visual_size": (5, 5)}, "10 × 20 pixels; expected square ones"),
    ],
)
def test_wrong_sizes_are_named(given, words):
    with pytest.raises(machband.Error, match=words):
        machband.Stimulus(**given)


def test_a_transfer_is_one_object(tmp_path):
    light = np.linspace(0, 1, 30).reshape(10, 3)
    for transfer, text in [
        (machband.Transfer.srgb(), "srgb"), (machband.Transfer.gamma(2.2), "gamma:2.2"),
        (machband.Transfer.gog(2, 0.9, 0.1), "gog:2,0.9,0.1"),
    ]:
        assert transfer == machband.Transfer(text) and np.allclose(transfer.decode(transfer.encode(light)), light)
        assert np.array_equal(machband.stimulus(size=16, transfer=transfer), machband.stimulus(size=16, transfer=text))
    channels = machband.Transfer("gamma:2/gamma:2.2/linear")
    assert np.allclose(channels.encode(light)[:, 2], light[:, 2]) and np.allclose(channels.encode(light)[:, 0], light[:, 0] ** 0.5)
    with pytest.raises(machband.Error, match=r"expected values of shape \(…, 3\)"):
        channels.encode(light[:, 0])
    # A wrong one is refused where it is made.
    with pytest.raises(machband.Error, match="missing.toml"):
        machband.Transfer.from_display(tmp_path / "missing.toml")
    with pytest.raises(machband.Error, match="gamma 0 is outside"):
        machband.Transfer.gamma(0)
    with pytest.raises(TypeError, match="gamma is '2.2'; expected a number"):
        machband.Transfer.gamma("2.2")
    (tmp_path / "screen.toml").write_text('schema = 1\nname = "screen"\ntransfer = "gamma:2.2"\n')
    profile = machband.Transfer.from_display(tmp_path / "screen.toml")
    assert np.array_equal(machband.stimulus(size=16, transfer=profile), machband.stimulus(size=16, transfer="gamma:2.2"))
    with pytest.raises(machband.Error, match="both a display profile"):
        machband.stimulus(transfer=profile, display="other.toml")


def test_a_color_of_the_web_is_one():
    [found] = machband.light(size=1, low=1, high=1, color="#ff8000")
    assert found[0] == pytest.approx(machband.Transfer().decode([1, 128 / 255, 0]))
    assert machband.Definition.from_dict(
        {"schema": 1, "name": "a", "stimulus": {"kind": "cornsweet", "color": "#FFFFFF"}}
    ).conditions()["color"].tolist() == ["gray"]


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
        assert np.allclose(machband.Transfer().decode(machband.Transfer().encode(view)), expected)
    assert math.isnan(machband.interpolate(math.nan))
    assert machband.interpolate([]).shape == (0,)


def test_srgb_is_the_standards():
    light = np.linspace(0, 1, 257)
    # IEC 61966-2-1.
    expected = np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055)
    assert np.abs(machband.Transfer().encode(light) - expected).max() < 1e-6


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
        ({"size": 20000}, "16384"),
        ({"bits": 12}, "expected one of 8, 16"),
        ({"width": math.nan}, "is not a number"),
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


@pytest.mark.parametrize("given", [{"size": "big"}, {"size": 3.5}, {"width": None}, {"width": [[1]]}, {"width": b"0.1"}, {"kind": None}, {"size": True}, {"transfer": 2.2}])
def test_wrong_types_are_refused(given):
    with pytest.raises(TypeError, match="expected"):
        machband.stimulus(**{"size": 32, **given})


def test_wrong_keywords_are_named():
    for call, near in [
        (lambda: machband.interpolate(0.5, dpeth=2), "depth"), (lambda: machband.stimulus(sise=2), "size"),
        (lambda: machband.predict(windw_deg=2), "window_deg"), (lambda: machband.Stimulus(vsual_size=2), "visual_size"),
        (lambda: machband.stimuli.mach_band(wdith=2), "width"), (lambda: machband.light(kid="kanizsa"), "kind"),
        (lambda: machband.verify(foldr="x"), "folder"), (lambda: machband.read_results(foler="x"), "folder"),
        (lambda: machband.parameters(knd="x"), "kind"), (lambda: machband.Transfer(functon="x"), "function"),
        (lambda: machband.Transfer.gamma(gama=2), "gamma"), (lambda: machband.Transfer().encode(ligth=1), "light"),
        (lambda: machband.stimuli.chevreul().plot(axes=1), "ax"), (lambda: machband.Figure("a", "", b"").plot(axes=1), "ax"),
        (lambda: machband.Definition.from_dict(kes={}), "keys"), (lambda: machband.Definition("quick").save(fil="x"), "file"),
    ]:
        with pytest.raises(TypeError, match=f"did you mean '{near}'"):
            call()


def test_wrong_words_are_named():
    for call, near in [
        (lambda: machband.stimulus(color="grey"), "gray"), (lambda: machband.stimulus(dither="bluenoise"), "blue-noise"),
        (lambda: machband.stimulus(transfer="sRGB"), "srgb"), (lambda: machband.stimulus(space="hvs"), "hsv"),
    ]:
        with pytest.raises(machband.Error, match=f"did you mean '{near}'"):
            call()


def test_a_stimulus_does_not_change():
    color = np.array([1, 0, 0])
    made = machband.stimuli.mach_band(color=color, depth=np.inf, size=8)
    color[:] = 1
    assert made.light[0, 0].tolist() == [0.25, 0, 0]
    assert made == machband.stimuli.mach_band(color=[1, 0, 0], depth="inf", size=8)
    assert eval(repr(made), {"Stimulus": machband.Stimulus}) == made
    # What means the same is the same, and a number of 32 bits is the one that it is written as.
    of_text = machband.stimuli.mach_band(width=np.float32(0.2), orientation_deg="45", color="1,0,0", size=8)
    assert {of_text} == {machband.stimuli.mach_band(width=0.2, orientation_deg=45, color="red", size=8)}
    with pytest.raises(AttributeError, match="width of a stimulus cannot be set; expected another"):
        made.width = 0.1


SCREEN = {"px": 1, "screen_px": 1920, "screen_cm": 50, "distance_cm": 57}


@pytest.mark.parametrize(
    ("ask", "error", "words"),
    [
        (lambda: machband.stimulus(display=3), TypeError, "display is 3; expected a path"),
        (lambda: machband.visual_angle(**{**SCREEN, "screen_cm": "50"}), TypeError, "screen_cm is '50'; expected a number"),
        (lambda: machband.visual_angle(**{**SCREEN, "screen_px": 9}), machband.Error, "^screen_px 9 is outside 16…65536"),
        (lambda: machband.visual_angle(**{**SCREEN, "screen_cm": 3}), machband.Error, "^screen_cm 3 is outside 5…500"),
        (lambda: machband.visual_angle(**{**SCREEN, "distance_cm": np.inf}), machband.Error, "^distance_cm inf is outside"),
        (lambda: machband.visual_angle(**{**SCREEN, "px": None, "deg": 180}), machband.Error, "expected less than 180"),
        (lambda: machband.interpolate([[0.1], [0.2, 0.3]]), TypeError, "u is .*; expected numbers"),
        (lambda: machband.read_results(3), TypeError, "folder is 3; expected a path"),
        (lambda: machband.Definition(3), TypeError, "name_or_path is 3; expected a path"),
        (lambda: machband.Transfer(3).encode(0.5), TypeError, "transfer is 3; expected text"),
        (lambda: machband.Transfer().encode(np.ma.masked_less([0.1, 0.2], 0.15)), TypeError, "light is a masked array"),
        (lambda: machband.Transfer().encode(np.uint8([0, 128])), machband.Error, "expected 0 to 1"),
        (lambda: machband.stimulus(width=np.array([0.2])), TypeError, r"width is array\(\[0.2\]\); expected a number"),
        (lambda: machband.stimulus(width=np.array([[0.2]])), TypeError, "expected a number"),
        (lambda: machband.Stimulus(size=20_000), machband.Error, "size 20000 is outside 1…16384"),
        (lambda: machband.Stimulus(size={8, 9}), TypeError, "expected a number, or height and width"),
        (lambda: machband.Stimulus(size="8"), TypeError, "size is '8'; expected a number, or height and width"),
        (lambda: machband.Stimulus(size=8).predict(window_deg=5), TypeError, "'window_deg'; expected one of display, white"),
        (lambda: machband.Stimulus(size=8).profile(size=5), TypeError, "'size'; expected one of transfer, bits"),
        (lambda: machband.stimulus(width=np.True_), TypeError, "width is .*True_?; expected a number or text"),
        (lambda: machband.stimulus(transfer=machband.Transfer), TypeError, "transfer is <class .*; expected text"),
        (lambda: machband.Transfer("linear", "x.toml"), machband.Error, "function is 'linear', and display 'x.toml'; expected one"),
        (lambda: machband.stimulus(transfer="gama:2"), machband.Error, "^transfer .gama:2. is not known; expected srgb"),
        (lambda: machband.mesh("blob", n_vertices=3), machband.Error, "^n_vertices: a blob cannot have 3 vertices"),
        (lambda: machband.interpolate(np.array([1], "M8[s]")), TypeError, "u is .*; expected numbers"),
    ],
)
def test_messages_name_the_argument_its_value_and_what_is_expected(ask, error, words):
    with pytest.raises(error, match=words):
        ask()


def test_arrays_without_dimensions_are_numbers():
    assert machband.Stimulus(size=np.array(8), width=np.array(np.float32(0.2))) == machband.Stimulus(size=8, width=0.2)
    assert machband.Transfer.gamma(np.float32(2.2)) == machband.Transfer.gamma(2.2)
    assert np.array_equal(machband.stimulus(size=8, width=np.array(0.2)), machband.stimulus(size=8, width=0.2))
