"""Experiments and data: one truth with the command, and nothing lost."""

import copy
import csv
import io
import pickle
import warnings
import xml.etree.ElementTree

import numpy as np
import pandas
import pytest

import machband
from conftest import needs


def test_a_definition_from_a_dict_is_the_files(tmp_path):
    keys = machband.Definition.load("bangay2003").to_dict()
    again = machband.Definition.from_dict(
        {
            "schema": 1,
            "name": "bangay2003",
            "title": keys["title"],
            "stimulus": {"kind": "mach-band", "low": 0.25, "high": 0.75, "color": "yellow"},
            "factors": {
                "width": np.array([0.02, 0.05, 0.1, 0.2, 0.4, 0.8]),
                "depth": [1, 2, 3, 4, float("inf")],
                "orientation_deg": (0, 45, 90, 135),
            },
            "design": {"repetitions": 2, "practice": 12, "break_every": 40, "order": "random"},
            "viewing": keys["viewing"],
            "recovery": keys["recovery"],
            "instructions": keys["instructions"],
            "response": {"question": keys["response"]["question"]},
        }
    )
    assert again.conditions().equals(machband.Definition("bangay2003").conditions())
    factors = {"width": [np.array(np.float32(0.1)), np.float32(0.2)], "depth": [np.int8(1), np.float32(np.inf)]}
    keys = {"schema": 1, "name": "d", "stimulus": {"kind": "mach-band"}, "factors": factors}
    assert machband.Definition.from_dict(keys).to_dict()["factors"]["width"] == [0.1, 0.2]
    assert again.schedule("P1", "2", 7).equals(machband.Definition("bangay2003").schedule("P1", "2", 7))
    file = tmp_path / "d.toml"
    file.write_text('schema = 1\nname = "d"\n[stimulus]\nkind = "cornsweet"\n')
    assert machband.Definition(file).sha256 == machband.Definition.from_dict(
        {"schema": 1, "name": "d", "stimulus": {"kind": "cornsweet"}}
    ).sha256


def test_a_definition_can_be_saved_copied_and_compared(tmp_path):
    for name in ["quick", "bangay2003", "orientation", "shaders"]:
        definition = machband.Definition(name)
        definition.save(tmp_path / f"{name}.toml")
        assert machband.Definition(tmp_path / f"{name}.toml") == definition == pickle.loads(pickle.dumps(definition))
    assert definition != machband.Definition("quick") and len({definition, copy.deepcopy(definition)}) == 1
    with pytest.raises(machband.Error, match="quick.toml: File exists; expected a new file"):
        definition.save(tmp_path / "quick.toml")


@pytest.mark.parametrize(
    ("keys", "words"),
    [
        ({"schema": 1, "name": "a", "stimulus": {"kind": "mach-band"}, "factors": {"widht": [1]}}, "did you mean width"),
        ({"schema": 1, "nmae": "a"}, "did you mean name"),
        ({"schema": 1, "name": "a b", "stimulus": {"kind": "mach-band"}}, "name"),
        ({}, "schema is missing"),
        ({"schema": 1, "factors": {"depth": [-np.inf]}}, 'depth "-inf" is not a whole number'),
    ],
)
def test_wrong_definitions_are_refused(keys, words):
    with pytest.raises(machband.Error, match=words):
        machband.Definition.from_dict(keys)
    with pytest.raises(machband.Error, match="did you mean quick"):
        machband.Definition("qiuck")
    with pytest.raises(TypeError, match="keys is .1.; expected a dict"):
        machband.Definition.from_dict([1])


def test_the_trials_are_the_sessions(sessions):
    _, rows = sessions
    planned = machband.Definition("quick").schedule("S002", "1", 5)
    shown = rows[rows.subject_id == "S002"].reset_index(drop=True)
    for name in ["phase", "block", "trial", "repetition", "width", "depth"]:
        assert planned[name].tolist() == shown[name].tolist()
    conditions = machband.Definition("quick").conditions()
    assert conditions["width"].take(planned["condition"]).tolist() == planned["width"].tolist()


def test_sessions_are_the_commands(command, sessions, tmp_path):
    folder, _ = sessions
    command("simulate", "quick", "--participants", 6, "--seed", 5, "--results", "results")
    for ours in sorted((folder / "quick" / "data").glob("*_data.csv")):
        told = list(csv.DictReader(io.StringIO((tmp_path / "results" / "quick" / "data" / ours.name).read_text())))
        found = list(csv.DictReader(io.StringIO(ours.read_text())))
        for row in [*told, *found]:
            del row["started_at"]
        assert found == told


def test_reading_loses_nothing(sessions):
    folder, rows = sessions
    texts = []
    for file in sorted((folder / "quick" / "data").glob("*_data.csv")):
        texts += list(csv.DictReader(io.StringIO(file.read_text())))
    assert len(rows) == len(texts) and list(rows) == [*texts[0], "simulated"]
    for name in texts[0]:
        for cell, text in zip(rows[name], [row[name] for row in texts], strict=True):
            if text == "":
                assert pandas.isna(cell)
            elif name == "started_at":
                assert cell == pandas.Timestamp(text)
            elif isinstance(cell, str):
                assert cell == text
            else:
                assert cell == float(text)
    assert rows.attrs["units"]["response_time_s"] == "s"
    assert "band" in rows.attrs["descriptions"]["rating"]
    assert isinstance(rows.subject_id[0], str) and str(rows.started_at.dt.tz) == "UTC"


def test_factors_of_several_experiments_become_columns(tmp_path):
    for name, kind, factor, levels in [("one", "chevreul", "steps", [3, 5]), ("two", "cornsweet", "exponent", [1, 2.5])]:
        keys = {"schema": 1, "name": name, "stimulus": {"kind": kind}, "factors": {factor: levels}}
        machband.simulate(keys, results=tmp_path)
    rows = machband.read_results(tmp_path)
    assert set(rows.experiment) == {"one", "two"}
    for name, factor, levels in [("one", "steps", {3, 5}), ("two", "exponent", {1, 2.5})]:
        assert set(rows[factor][rows.experiment == name]) == levels
        assert rows[factor][rows.experiment != name].isna().all()
        assert rows.attrs["descriptions"][factor] == machband.parameters("chevreul" if name == "one" else "cornsweet")[factor].description
    # A session that has the name of a level stays text.
    assert set(rows.session_id) == {"1"} and list(rows)[-5:-3] == ["sitting", "seed"]


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({}, ""),
        ({"terms": ["width", "num:inv_n"], "link": "probit", "random": "none"}, "--terms width,num:inv_n --link probit --random none"),
        ({"exclude": ["S002"], "only": {"width": [0.1, 0.4, 0.8]}}, "--exclude S002 --only width=0.1,0.4,0.8"),
    ],
)
def test_tables_are_the_commands(command, sessions, tmp_path, given, words):
    folder, rows = sessions
    words = words.split()
    command("analyze", folder / "quick", "--out", "analysis", "--draws", 99, *words)
    found = machband.analyze(folder / "quick", draws=99, **given)
    names = {path.name for path in (tmp_path / "analysis").iterdir()}
    for name, content in found.files.items():
        told = (tmp_path / "analysis" / name).read_bytes()
        # The script says where the data are.
        assert content == told or name == "analysis.R"
    assert names == {*found.files, *found._report_files}
    for name in ["figure4a.svg", "figure4b.png"]:
        assert found._report_files[name] == (tmp_path / "analysis" / name).read_bytes()
    assert found.tables["cells"]["n"].sum() == found.model["nobs"]
    assert (machband.analyze(rows, draws=99, **given).files["cells.csv"]) == found.files["cells.csv"]


def test_a_data_frame_has_the_results_of_its_files(sessions):
    folder, rows = sessions
    files, frame = machband.analyze(folder / "quick", draws=99), machband.analyze(rows, draws=99)
    columns = machband.analyze({name: rows[name].tolist() for name in ["subject_id", "rating", "width", "depth"]},
                               subject="subject_id", response="rating", factors=["width", "depth"], draws=99)
    main = rows[rows.phase == "main"]
    for table in files.tables:
        assert files.tables[table].equals(frame.tables[table]), table
    assert columns.tables["cells"]["n"].sum() == len(rows) and files.tables["cells"]["n"].sum() == len(main)
    assert files.model["loglik"] == frame.model["loglik"]
    assert "simulated" in files.summary() and "simulated" in frame.summary()
    by_width = main.groupby("width").rating.mean()
    assert np.allclose(files.tables["by_width"].set_index("width")["mean"], by_width)


def test_a_notebook_shows_the_results(sessions, tmp_path):
    found = machband.analyze(sessions[0], draws=99)
    html = found._repr_html_()
    assert html.count("<svg") == len(found.figures) >= 5 and "participants" in html
    for figure in found.figures.values():
        assert xml.etree.ElementTree.fromstring(figure._repr_svg_()).tag.endswith("svg")
        assert figure.png.startswith(b"\x89PNG")
    assert found.report.startswith("<!DOCTYPE html>") and repr(found) == found.summary()
    of_frame = machband.analyze(sessions[1], draws=99).report
    assert "analyze(table, categories=[0, 1, 2, 3], draws=99, response='rating')" in of_frame.replace("&#39;", "'")
    assert "machband analyze" not in of_frame
    written = found.save(tmp_path / "analysis")
    assert {path.name for path in written} == {*found.files, *found._report_files}
    with pytest.raises(machband.Error, match="already exists; expected a new file, or force=True"):
        found.save(tmp_path / "analysis")
    with pytest.raises(machband.Error, match="is an input"):
        found.save(sessions[0])
    found.save(tmp_path / "analysis", force=True)


def test_ordered_texts_missing_values_and_counts():
    frame = pandas.DataFrame(
        {
            "who": ["007", "007", "8", "8"] * 6,
            "answer": ["low", "mid, or so", "high", None] * 6,
            "width": np.float32([0.5, 1, 0.5, 1] * 6),
            "n": np.int8([1, 2, 3, 4] * 6),
        }
    )
    given = dict(subject="who", response="answer", factors=["width"], draws=99)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        found = machband.analyze(frame, count="n", categories=["low", "mid, or so", "high"], **given)
    assert [str(warning.message) for warning in caught] == [*found.warnings, *found.errors]
    assert found.errors == [] and found.warnings[-1].startswith("table: 6 of 24 rows have no response (")
    assert found.tables["cells"]["width"].tolist() == [0.5, 1]
    assert found.tables["cells"]["n"].tolist() == [24, 12]
    assert found.tables["subjects"]["subject_id"].tolist() == ["007", "8"]
    frame["answer"] = pandas.Categorical(frame.answer, ["low", "mid, or so", "high"], ordered=True)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        assert machband.analyze(frame, count="n", **given).files["cells.csv"] == found.files["cells.csv"]


def test_a_scale_is_that_of_the_data_or_named(tmp_path):
    frame = pandas.DataFrame({"subject_id": [*"abcd"] * 12, "width": [0.1] * 24 + [0.2] * 24, "rating": [1, 2, 3, 4] * 12})
    given = dict(factors=["width"], draws=99)
    assert machband.analyze(frame, **given).tables["by_width"]["n"].tolist() == [24, 24]
    expected = machband.analyze(frame, response="rating", **given)
    assert not expected.errors and expected.tables["by_width"]["n"].tolist() == [24, 24]
    frame.to_csv(tmp_path / "ratings.csv", index=False)
    assert machband.analyze(tmp_path / "ratings.csv", **given).files == expected.files
    # An ordered Categorical, and categories, say which scale it is.
    names = ["none", "low", "mid", "high"]
    frame["rating"] = frame.rating.map(dict(zip([1, 2, 3, 4], names, strict=True)))
    told = machband.analyze(frame, categories=names, **given).files["tests.csv"]
    frame["rating"] = pandas.Categorical(frame.rating, names, ordered=True)
    assert machband.analyze(frame, **given).files["tests.csv"] == told == expected.files["tests.csv"]
    # Named levels of an index are columns.
    assert machband.analyze(frame.set_index("subject_id"), **given).files["tests.csv"] == told


def test_codes_and_columns_that_are_levels():
    frame = pandas.DataFrame({"id": [f"p{i}" for i in range(24)], "near": [1, 2, 3, 4] * 6, "far": [2, 3, 99, 2] * 6})
    with pytest.raises(ValueError, match=r"99 \(6 ratings\) is far from the other values.*missing=.99"):
        machband.analyze(frame, subject="id", wide="near,far", draws=99)
    with pytest.warns(UserWarning, match="6 of 48 rows have no response"):
        found = machband.analyze(frame, subject="id", wide=["near", "far"], missing=99, draws=99)
    assert found.tables["by_condition"]["n"].tolist() == [18, 24]


def test_ratings_without_a_level_are_a_warning(sessions):
    frame = sessions[1][["subject_id", "width", "rating"]].copy()
    frame.loc[:3, "width"] = np.nan
    with pytest.warns(UserWarning, match="4 ratings without a value of width are excluded|4 of 168 ratings have no"):
        found = machband.analyze(frame, factors=["width"], draws=99, slopes="none")
    told = ["table: 4 of 168 ratings have no value", "the model: 4 ratings without a value of width are excluded"]
    assert [one.startswith(start) for one, start in zip(found.warnings, told, strict=True)] == [True, True]
    assert not found.model["random"]["slopes"]


@pytest.mark.parametrize("seed", [2**53 + 1, 2**63 + 12345, 2**64 - 1])
def test_large_seeds_are_exact(seed):
    rows = machband.simulate("quick", seed=seed)
    assert rows.seed.tolist() == [seed] * len(rows)
    definition = machband.Definition("quick")
    assert definition.schedule("S001", 1, seed).width.tolist() == rows.width.tolist()


def test_generators_of_numpy_are_seeds():
    for make in [np.random.default_rng, np.random.SeedSequence]:
        rows, again = (machband.simulate("quick", seed=make(3)) for _ in range(2))
        assert rows.seed[0] == again.seed[0] > 2**32 and rows.width.tolist() == again.width.tolist()


@pytest.mark.parametrize(
    ("data", "given", "error", "words"),
    [
        ("missing", {}, machband.Error, "missing"),
        (7, {}, TypeError, "data is 7; expected paths, or one DataFrame or dict of columns"),
        ([], {}, ValueError, "required arguments were not provided: data"),
        ({}, {}, ValueError, "required arguments were not provided"),
        (pandas.Series([1, 2]), {}, TypeError, "(?s)data is .*; expected paths"),
        ({"subject_id": ["a"], "rating": [7], "width": [1]}, {}, machband.Error, "^table"),
        ({"a": [1], "b": [1, 2]}, {}, ValueError, "b has length 2; expected 1, as a has"),
        ({"a": [[1]]}, {}, ValueError, "one dimension"),
        ({"a": np.array("b")}, {}, TypeError, "column 'a' is array.* expected a list or an array"),
        ({b"subject_id": ["a"], b"rating": [7]}, {"factors": "c"}, machband.Error, "expected one of subject_id, rating"),
        ({"subject_id": [*"ab"] * 9, "rating": [0, 1, 2] * 5 + [-99] * 3, "w": [*"xy"] * 9}, {"factors": "w"}, machband.DataError, "such as missing=.-99.$"),
        ({"subject_id": ["a"], "rating": [1]}, {"link": "lgoit"}, machband.Error, "logit"),
        ({"subject_id": ["a"], "rating": [1]}, {"lnik": "logit"}, TypeError, "did you mean 'link'"),
        ({"subject_id": ["a", "b"], "rating": [1, 2]}, {"terms": "depht"}, machband.Error, "^table: .* depht"),
        ([{"subject_id": "a", "rating": 1}], {}, TypeError, "data is {.*; expected .* dict of columns"),
        (pandas.DataFrame([[1, 2, 3]], columns=["subject_id", "rating", "rating"]), {"terms": "w"}, machband.Error, "rating appears twice"),
        (pandas.DataFrame([[1]], columns=pandas.MultiIndex.from_tuples([("a", "b")])), {}, machband.Error, "2 levels"),
        ({"p": ["a"], "x": [1]}, {"subject": "P", "response": "x"}, machband.Error, "expected one of p, x; did you mean p.$"),
        ({"subject_id": ["a"], "rating": [1]}, {"large": "no"}, TypeError, "large is 'no'; expected True or False"),
        ({"subject_id": ["a"], "rating": [1]}, {"response": ["rating"]}, TypeError, r"response is \['rating'\]; expected text"),
        ({"subject_id": ["a"], "rating": [1]}, {"wide": []}, machband.Error, "wide"),
        ({"subject_id": ["a"], "rating": ["x"]}, {"categories": {"x", "y"}}, TypeError, "categories is {.*; expected a list of texts"),
        ({"subject_id": ["a"], "rating": [1]}, {"categories": [0, np.nan, 1]}, TypeError, "categories is .*; expected a list of texts"),
        ({"subject_id": ["a"], "rating": [3]}, {"missing": b"3"}, TypeError, "missing is b'3'; expected a list of texts"),
    ],
)
def test_wrong_data_are_refused(data, given, error, words):
    with pytest.raises(error, match=words):
        machband.analyze(data, **given)


def test_the_model_is_like_statsmodels(sessions):
    found = machband.analyze(sessions[1], draws=99, slopes="none")
    names = [row["name"] for row in [*found.model["thresholds"], *found.model["coefficients"]]]
    assert found.params.index.tolist() == names == found.bse.index.tolist() == found.pvalues.index.tolist()
    assert found.cov_params().index.tolist() == found.cov_params().columns.tolist() == names
    assert np.allclose(np.sqrt(np.diag(found.cov_params())), found.bse, rtol=1e-6)
    # Calibrated: with one degree of freedom the likelihood-ratio test, otherwise the comparison with the baseline.
    [test] = [test for test in found.model["likelihood_ratio"] if test["df"] == 1]
    assert found.pvalues["orientation_deg90"] == test["p"] and found.pvalues[:3].isna().all()
    compared = found.tables["tests"].query("test == 'comparison' and level == '0.8' and other == '0.02'")
    assert found.pvalues["width0.8"] == pytest.approx(compared.p.item())
    ends, wide = found.conf_int(), found.conf_int(0.01)
    assert ((ends.lower < found.params) & (found.params < ends.upper)).all() and (wide.upper > ends.upper).all()
    assert found.aic == pytest.approx(2 * found.model["parameters"] - 2 * found.llf) and found.bic > found.aic
    table = found.tables["predictions"]
    shares = found.predict(table)
    assert np.allclose(shares.sum(axis=1), 1) and list(shares) == list("0123")
    # With next to no differences between people, this is what is expected over people.
    assert np.allclose(shares, table[["p0", "p1", "p2", "p3"]], atol=0.02)
    with pytest.raises(machband.Error, match="width is 0.3, which was not analyzed; expected one of 0.02, 0.1"):
        found.predict({"width": [0.3], "depth": [1], "orientation_deg": [0]})
    given = {"width": pandas.Categorical([0.4], [0.4, 0.9]), "depth": [1], "orientation_deg": [0]}
    assert found.predict(pandas.DataFrame(given, index=["a"])).index.tolist() == ["a"]
    with pytest.raises(machband.Error, match="depth has length 2; expected 1, as width has"):
        found.predict({**given, "depth": [1, 2]})
    with pytest.raises(TypeError, match="column 'depth' is 1; expected a list or an array"):
        found.predict({**given, "depth": 1})
    with pytest.raises(TypeError, match="alpha is '0.05'; expected a number"):
        found.conf_int("0.05")
    numeric = machband.analyze(sessions[1], draws=99, terms="num:width", link="probit")
    assert (np.diff(numeric.predict({"width": [0.1, 0.33, 0.8]})["3"]) < 0).all()


def test_without_a_model_the_reason_is_told():
    found = machband.analyze({"subject_id": ["a"] * 4, "rating": [1] * 4, "dose": ["x", "y"] * 2}, factors=["dose"], draws=99)
    for ask in [
        lambda: found.params, lambda: found.aic, lambda: found.bic, lambda: found.llf, lambda: found.pvalues,
        lambda: found.bse, found.conf_int, found.cov_params, lambda: found.predict({"dose": ["x"]}),
    ]:
        with pytest.raises(machband.Error, match="no model was fitted, because every rating is 1"):
            ask()
    assert found.nobs == 4 and pickle.loads(pickle.dumps(found)).summary() == found.summary()


def test_results_pickle_and_plot(sessions, tmp_path):
    needs("matplotlib")
    import matplotlib

    matplotlib.use("Agg")
    found = machband.analyze(sessions[1], draws=99)
    for again in [pickle.loads(pickle.dumps(found)), copy.deepcopy(found)]:
        assert (again.files, again.report, repr(again)) == (found.files, found.report, repr(found))
        assert again.tables["cells"].equals(found.tables["cells"]) and again.params.equals(found.params)
        assert again.cov_params().equals(found.cov_params()) and again.figures == found.figures
    assert len(again.save(tmp_path / "again")) == len(found.save(tmp_path / "found"))
    assert (tmp_path / "again" / "report.html").read_bytes() == (tmp_path / "found" / "report.html").read_bytes()
    figure = found.figures["effects"]
    assert repr(figure) == "<Figure 'effects'>" and len(figure.plot().images) == 1
    with pytest.raises(TypeError, match="ax is 3; expected axes of matplotlib"):
        figure.plot(3)


BASE = {"schema": 1, "name": "t", "stimulus": {"kind": "mach-band", "color": "gray"}}
TASKS = {
    "choice": {
        "factors": {"orientation_deg": [0, 90]}, "task": {"kind": "choice", "reference": {"depth": "inf"}},
        "adaptive": {"method": "quest-plus", "parameter": "width", "levels": [0.005, 0.01, 0.02, 0.04], "trials": 20},
    },
    "yes-no": {"factors": {"width": [0.05, 0.1, 0.2]}, "task": {"kind": "yes-no", "reference": {"depth": "inf"}}},
    "pair": {"factors": {"width": [0.05, 0.1, 0.2]}, "task": {"kind": "pair"}},
    "ranking": {"factors": {"width": [0.05, 0.1, 0.2]}, "task": {"kind": "pair", "pairs": "adaptive", "trials": 12}},
    "adjust": {"factors": {"depth": [1, 2]}, "task": {"kind": "adjust", "parameter": "nulling"}},
}


@pytest.mark.parametrize(
    ("task", "tables"),
    [
        ("choice", ["answers", "thresholds", "population"]), ("yes-no", ["detection"]), ("pair", ["comparisons", "scale"]),
        ("ranking", ["comparisons", "scale"]), ("adjust", ["settings"]),
    ],
)
def test_tasks_go_the_whole_way(command, tmp_path, task, tables):
    definition = machband.Definition.from_dict({**BASE, **TASKS[task]})
    definition.save(tmp_path / "t.toml")
    assert machband.Definition(tmp_path / "t.toml") == definition
    rows = machband.simulate(definition, participants=3, seed=2, results=tmp_path)
    trials = definition.schedule("S002", "1", 2)
    mine = rows[rows.subject_id == "S002"].reset_index(drop=True)
    # A method that follows the answers plans neither the pair nor the number of trials.
    assert mine.trial.tolist() == trials.trial[: len(mine)].tolist()
    for name in {*trials} & {"orientation_deg", "width", "width_2", "depth"} - {"width" if task == "choice" else ""}:
        assert mine[name].tolist() == trials[name][: len(mine)].tolist()
    assert machband.read_results(tmp_path).equals(rows) and set(rows.task) == {TASKS[task]["task"]["kind"]}
    found = machband.analyze(tmp_path / "t")
    # With few people, conditions may not be compared.
    assert [name for name in found.tables if name != "differences"] == tables and "simulated" in repr(found) and "simulated" in found.report
    command("analyze", tmp_path / "t", "--out", "out")
    assert {path.name for path in (tmp_path / "out").iterdir()} == {path.name for path in found.save(tmp_path / "ours")}
    for name, content in found.files.items():
        assert content == (tmp_path / "out" / name).read_bytes()
    assert repr(pickle.loads(pickle.dumps(found))) == repr(found)
    with pytest.raises(machband.Error, match="a task has no ordinal model; expected one of the tables"):
        found.params
    with pytest.raises(machband.Error, match="expected the folder of their sessions"):
        machband.analyze(rows)


def test_changes_are_found(command, tmp_path):
    machband.simulate("quick", participants=2, results=tmp_path)
    found = machband.verify(tmp_path)
    assert found and len(machband.verify(tmp_path / "quick").sessions) == 2
    assert command("verify", tmp_path).splitlines()[:-1] == [f"{file}: {said}" for file, said in found.sessions.items()]
    file = next((tmp_path / "quick" / "data").glob("*S001*_data.csv"))
    text = file.read_text()
    file.write_text(text.replace(",mach-band,", ",mach-band,", 1).replace("0.25,0.75", "0.25,0.70", 1))
    found = machband.verify(tmp_path)
    assert not found and any("S001" in error for error in found.errors)
    assert command("verify", tmp_path, status=1).splitlines() == [f"error: {error}" for error in found.errors]
    with pytest.raises(machband.Error, match="nowhere: does not exist; expected"):
        machband.verify(tmp_path / "nowhere")
    (tmp_path / "empty").mkdir()
    with pytest.raises(machband.Error, match="contains no session"):
        machband.verify(tmp_path / "empty")


@pytest.mark.parametrize("format", ["bids", "psych-ds"])
def test_an_export_is_the_commands(command, sessions, tmp_path, format):
    folder, _ = sessions
    found = machband.export(folder, tmp_path / "ours", format)
    assert found.experiments == ["quick"] and found.sessions == 6
    command("export", folder, "--format", format, "--out", "told")
    files = lambda root: {path.relative_to(root): path.read_bytes() for path in root.rglob("*") if path.is_file()}
    assert files(tmp_path / "ours") == files(tmp_path / "told")
    with pytest.raises(machband.Error, match="empty"):
        machband.export(folder, tmp_path / "ours", format)
    with pytest.raises(machband.Error, match="bids, psych-ds"):
        machband.export(folder, tmp_path / "new", "bdis")


def test_an_interrupted_simulation_resumes(tmp_path):
    machband.simulate("quick", participants=1, results=tmp_path)
    with pytest.raises(machband.Error, match="S001"):
        machband.simulate("quick", participants=2, results=tmp_path)
    assert len(machband.simulate("quick", participants=2, results=tmp_path, resume=True)) == 56
    for given, words in [({"resume": True}, "resume is True without results"), ({"observer": "visoin"}, "vision")]:
        with pytest.raises(machband.Error, match=words):
            machband.simulate("quick", **given)


def test_answers_at_levels():
    """A table of answers gives the same thresholds as a dict and as a file, and psignifit's."""
    right = [45, 50, 44, 44, 52, 53, 62, 64, 76, 79, 88, 90, 90]
    table = {
        "level": [0.001, 0.0015, 0.002, 0.0025, 0.003, 0.0035, 0.004, 0.0045, 0.005, 0.006, 0.007, 0.008, 0.01],
        "right": right,
        "n": [90] * 13,
    }
    found = machband.analyze(table, level="level", correct="right", total="n", guess=0.5)
    assert abs(found.tables["thresholds"]["threshold"].iloc[0] / 0.00464644 - 1) < 0.01
    with pytest.raises(machband.Error, match="row 3 .counted from 0.: right is .99.; expected no more correct answers than trials") as caught:
        machband.analyze({**table, "right": [*right[:3], 99, *right[4:]]}, level="level", correct="right", total="n", guess=0.5)
    assert caught.value.rows.tolist() == [3] and isinstance(caught.value, machband.DataError)
    with pytest.raises(machband.Error, match="required arguments were not provided: guess"):
        machband.analyze(table, level="level", correct="right", total="n")
    with pytest.raises(machband.Error, match="required arguments were not provided: .*level"):
        machband.analyze(table, total="n")
    # The usual column has the participants, and rows without an answer or, if asked, with a wrong one are left out.
    people = pandas.DataFrame({**table, "right": [*right[:12], None]}).iloc[[*range(12)] * 5 + [12]]
    people["subject_id"] = [*"ab"] * 30 + ["a"]
    given = dict(level="level", correct="right", total="n", guess=0.5)
    with pytest.warns(machband.DataWarning, match="1 of 61 rows has no level or no answer, and was left out"):
        expected = machband.analyze(people, **given)
    assert expected.summary().startswith("2 participants gave 5,400 answers")
    wrong = pandas.concat([people.iloc[:60], people.iloc[:1].assign(right=91)])
    with pytest.warns(machband.DataWarning, match="row 60 .counted from 0.: right is .91."):
        found = machband.analyze(wrong, on_error="drop", **given)
    assert found.files == expected.files and len(found.errors) == len(expected.warnings) == 1
    assert "These data are simulated: a program gave the answers" in machband.analyze({**table, "simulated": [1] * 13}, **given).report
