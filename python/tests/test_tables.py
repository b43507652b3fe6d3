"""Data enter from any table without detours, wrong ones are refused with their positions, and nothing is forgotten."""

import html
import io
import sys
import time
import warnings

import numpy as np
import pandas
import pytest

import machband
from conftest import needs

GIVEN = dict(subject="who", response="answer", factors=["dose"], draws=99)


def study(**changes):
    """Return a table of 48 answers by four people on a scale of three words, at two doses."""
    columns = {
        "who": ["007", "8", "=c", "@d"] * 12,
        "answer": ["low", "mid, or so", "high", "low", "high", "high"] * 8,
        "dose": ["none"] * 24 + ["a lot"] * 24,
    }
    frame = pandas.DataFrame({**columns, **changes})
    frame["answer"] = pandas.Categorical(frame.answer, ["low", "mid, or so", "high"], ordered=True)
    return frame


def test_every_kind_of_table_is_the_same():
    needs("polars"), needs("pyarrow"), needs("duckdb")
    import duckdb
    import polars
    import pyarrow

    frame = study(answer=["low", "mid, or so", "high", None, "high", "high"] * 8, n=np.int8([1, 2, 3, 4] * 12))
    expected = None
    enum = polars.Enum(list(frame.answer.cat.categories))
    pl = polars.from_pandas(frame.astype({"answer": object})).with_columns(polars.col("answer").cast(enum))
    words = dict(zip(frame, [frame.who.to_numpy(), frame.answer.astype(object).to_numpy(), frame.dose, frame.n], strict=True))
    relation = duckdb.from_arrow(pyarrow.table(pl))
    scale = {"categories": ["low", "mid, or so", "high"]}
    enums = relation.project(f"* REPLACE (answer::ENUM{(*scale['categories'],)} AS answer)")
    for table, further in [
        (frame, {}), (frame.set_index("who"), {}), (pl, {}), (pyarrow.table(pl), {}), (pyarrow.table(pl).to_reader(), {}),
        (relation, scale), (enums, {}), (words, scale), (frame.astype({"who": object, "answer": object}), scale),
        (np.array(list(zip(*words.values(), strict=True)), [(name, "O") for name in words]), scale),
    ]:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", machband.DataWarning)
            found = machband.analyze(table, count="n", **GIVEN, **further)
        assert any("8 of 48 rows have no response" in warning for warning in found.warnings)
        expected = expected or found.files
        assert found.files == expected
    assert found.tables["subjects"]["subject_id"].tolist() == ["007", "8", "=c", "@d"]
    assert found.tables["cells"]["n"].tolist() == [48, 48]


def test_polars_needs_neither_pandas_nor_pyarrow(monkeypatch):
    needs("polars")
    import polars

    words, doses = ["low", "mid, or so", "high"], ["none", "a lot"]
    rows = {"who": ["007", "8", "=c", "@d"] * 12, "answer": ["low", "mid, or so", "high", None, "high", "high"] * 8}
    frame = polars.DataFrame({**rows, "dose": ["none"] * 24 + ["a lot"] * 24, "n": [1, 2, 3, None] * 12})
    frame = frame.with_columns(answer=polars.col("answer").cast(polars.Enum(words)), dose=polars.col("dose").cast(polars.Enum(doses)))
    monkeypatch.setitem(sys.modules, "pandas", None)
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    with pytest.warns(machband.DataWarning, match="8 of 48 rows have no response"):
        found = machband.analyze(frame.drop("n"), **GIVEN)
    with pytest.warns(machband.DataWarning, match="8 of 48 rows have no response"):
        assert machband.analyze({**rows, "dose": frame["dose"]}, categories=words, **GIVEN).files == found.files
    assert [*dict.fromkeys(found.tables["cells"]["dose"])] == doses
    with pytest.raises(machband.DataError, match="n is "):
        machband.analyze(frame, count="n", **GIVEN)


def test_the_call_that_repeats_an_analysis_has_plain_values():
    given = {**GIVEN, "factors": {"dose": np.array(["none", "a lot"])}, "draws": np.int64(99)}
    report = html.unescape(machband.analyze(study(), **given).report)
    assert "draws=99" in report and "factors={'dose': ['none', 'a lot']}" in report


def test_a_frame_is_its_csv(command, tmp_path):
    frame = study().astype({"who": object})
    frame["who"] = frame.who.str.replace("[=@]", "x", regex=True)
    frame.to_csv(tmp_path / "ratings.csv", index=False)
    words = ["--subject", "who", "--response", "answer", "--factors", "dose", "--draws", 99, "--levels", "dose=none,a lot"]
    command("analyze", "ratings.csv", *words, "--categories", 'low,"mid, or so",high', "--out", "out")
    found = machband.analyze(frame, **{**GIVEN, "factors": {"dose": ["none", "a lot"]}})
    for name, content in found.files.items():
        assert content == (tmp_path / "out" / name).read_bytes(), name


def test_wrong_rows_raise_with_their_positions():
    frame = pandas.DataFrame({"who": [*"abcd"] * 150, "rating": np.tile([1.0, 2, 3, 4, 5, 6], 100), "dose": [1, 2] * 300})
    given = dict(subject="who", factors=["dose"], draws=99)
    # No scale is assumed: all seven categories that occur count.
    assert machband.analyze(frame, **given).tables["by_dose"]["n"].tolist() == [300, 300]
    with pytest.raises(machband.DataError, match="rating is \"6\".*row|row.*6") as caught:
        machband.analyze(frame, categories=[1, 2, 3, 4, 5], **given)
    assert caught.value.rows.tolist() == list(range(5, 600, 6)) and isinstance(caught.value, machband.Error)
    few = frame.assign(rating=frame.rating.where(frame.index != 7, 9).replace(6, 5))
    with pytest.raises(machband.DataError) as caught:
        machband.analyze(few, categories=[1, 2, 3, 4, 5], **given)
    assert caught.value.rows.tolist() == [7]
    with pytest.warns(machband.DataWarning, match="row 7"):
        found = machband.analyze(few, categories=[1, 2, 3, 4, 5], on_error="drop", **given)
    assert len(found.errors) == 1 and found.tables["by_dose"]["n"].sum() == 599
    continuous = frame.assign(rating=np.random.default_rng(1).random(600))
    with pytest.raises(machband.Error, match="categories"):
        machband.analyze(continuous, **given)
    with pytest.raises(machband.DataError, match="-99") as caught:
        machband.analyze(frame.replace({"rating": {6: -99}}), **given)
    assert caught.value.rows.tolist() == list(range(5, 600, 6))
    with pytest.raises(machband.DataError, match="100 of 600 rows have no participant") as caught:
        machband.analyze(frame.assign(who=frame.who.where(frame.rating < 6)), **given)
    assert caught.value.rows.tolist() == list(range(5, 600, 6))
    infinite = frame.assign(rating=frame.rating.where(frame.index != 7, np.inf))
    with pytest.raises(machband.DataError, match="rating: inf .1 rating. is far from the other values") as caught:
        machband.analyze(infinite, **given)
    assert caught.value.rows.tolist() == [7]
    with pytest.raises(machband.Error, match="on_error is 'ignore'"):
        machband.analyze(frame, on_error="ignore", **given)


def test_masks_are_missing_values():
    mask = np.arange(48) % 4 == 1
    table = {"who": [*"abcdef"] * 8, "dose": [1, 2] * 24}
    for values in [np.arange(48) % 3, (np.arange(48) % 3).astype(float), np.array([str(i % 3) for i in range(48)])]:
        with pytest.warns(machband.DataWarning, match="12 of 48 rows have no response"):
            masked = machband.analyze({**table, "answer": np.ma.masked_array(values, mask)}, **GIVEN)
        with pytest.warns(machband.DataWarning):
            blank = machband.analyze({**table, "answer": np.where(mask, np.nan, np.arange(48) % 3)}, **GIVEN)
        assert masked.files == blank.files


@pytest.mark.parametrize("how", ["categorical", "dict"])
def test_order_and_baseline_are_as_given(how):
    order = ["none", "little", "lots", "max"]
    frame = study(dose=np.tile(order[::-1], 12))
    if how == "categorical":
        frame["dose"] = pandas.Categorical(frame.dose, order, ordered=True)
    found = machband.analyze(frame, **{**GIVEN, "factors": ["dose"] if how == "categorical" else {"dose": order}})
    assert found.tables["by_dose"]["dose"].tolist() == order
    assert list(found.params.index[-3:]) == ["doselittle", "doselots", "dosemax"]
    natural = machband.analyze(study(dose=frame.dose.astype(object)), **GIVEN)
    assert natural.tables["by_dose"]["dose"].tolist() == sorted(order) and natural.llf == pytest.approx(found.llf, abs=1e-6)
    # Numbers out of their order are names.
    numbers = machband.analyze(study(dose=[3, 1] * 24), **{**GIVEN, "factors": {"dose": [3, 1]}})
    assert numbers.tables["by_dose"]["dose"].tolist() == ["3", "1"]
    with pytest.raises(machband.Error, match="dos.*did you mean dose"):
        machband.analyze(frame, **{**GIVEN, "factors": {"dos": order}})
    days = pandas.to_datetime(["2024-01-02", "2024-01-01"] * 24)
    for dose, order, baseline in [
        ([True, False] * 24, [True, False], "1"), (pandas.array([True, None, False] * 16, "boolean"), [True, False], "1"),
        (days, [*days[:2]], "2024-01-02"), (days, ["2024-01-02", "2024-01-01"], "2024-01-02"),
        ([0.5, 2] * 24, ["2.0", 0.5], "2"),
    ]:
        found = machband.analyze(study(dose=dose).dropna(), **{**GIVEN, "factors": {"dose": order}})
        assert found.tables["by_dose"]["dose"].astype(str).tolist()[0] == baseline


@pytest.mark.parametrize(
    ("order", "error", "words"),
    [
        (["nnone", "a lot"], machband.Error, "^factors: nnone is not a level of dose; expected .*; did you mean none"),
        (["none", "a lot", "none"], machband.Error, r"^factors\['dose'\] has none twice; expected each level once"),
        ([], machband.Error, r"^factors\['dose'\] has no level"),
        ("none,a lot", TypeError, "expected a list of levels"), (None, TypeError, "factors.'dose'. is None"),
    ],
)
def test_wrong_orders_are_refused(order, error, words):
    with pytest.raises(error, match=words):
        machband.analyze(study(), **{**GIVEN, "factors": {"dose": order}})
    # Levels that are not named follow, and True is 1.
    kept = machband.analyze(study(), **{**GIVEN, "factors": {"dose": ["none"]}})
    assert kept.tables["by_dose"]["dose"].tolist() == ["none", "a lot"]
    table = study(**{"a=b": [True, False] * 24})
    assert machband.analyze(table, **{**GIVEN, "factors": {"a=b": [True]}, "only": {"a=b": [True]}}).nobs == 24


def test_times_and_bytes_are_the_same_texts():
    needs("polars"), needs("pyarrow")
    import polars

    for written in [["2024-01-01", "2024-01-02"], ["2024-01-01T00:00:00.000100Z", "2024-01-01T00:00:00.000200Z"]]:
        times = np.array([text.rstrip("Z") for text in written], "M8[us]")
        frame = study(dose=np.tile(times, 24))
        enum = polars.col("answer").cast(polars.Enum([*frame.answer.cat.categories]))
        of_polars = polars.from_pandas(frame.astype({"answer": object})).with_columns(enum)
        for table in [frame, of_polars, frame.assign(dose=[time.item() for time in np.tile(times, 24)])]:
            assert machband.analyze(table, **GIVEN).tables["by_dose"]["dose"].tolist() == written
    frame = study(who=[b"a", b"b", b"c", b"d"] * 12)
    assert machband.analyze(frame, **GIVEN).tables["subjects"]["subject_id"].tolist() == [*"abcd"]


@pytest.mark.parametrize(
    ("dose", "error", "words"),
    [
        ([[1]] * 48, TypeError, "column 'dose' has cells of list"), ([{}] * 48, TypeError, "cells of dict"),
        (pandas.Series(["\ud800", "a"] * 24, dtype=object), machband.Error, "expected text in Unicode"),
        ([b"\xff", b"a"] * 24, machband.Error, "UTF-8"),
    ],
)
def test_wrong_cells_are_refused(dose, error, words):
    with pytest.raises(error, match=words):
        machband.analyze(study().assign(dose=dose), **GIVEN)


def test_wrong_tables_of_others_are_refused():
    needs("polars"), needs("pyarrow")
    import polars
    import pyarrow

    frame = polars.from_pandas(study().astype({"answer": object}))
    with pytest.raises(TypeError, match=r"LazyFrame is not computed yet; expected a DataFrame, such as from its .collect\(\)"):
        machband.analyze(frame.lazy(), **GIVEN)
    with pytest.raises(machband.Error, match="DataFrame cannot be read: "):
        machband.analyze(frame.with_columns(dose=polars.col("dose").str.split("")), **GIVEN)
    with pytest.raises(machband.Error, match="DataFrame cannot be read: .*expected columns that Arrow has"):
        machband.analyze(frame.with_columns(dose=polars.lit(1, polars.Int128)), **GIVEN)
    arrow = pyarrow.table(frame)
    with pytest.raises(machband.Error, match="the column dose appears twice"):
        machband.analyze(arrow.append_column("dose", arrow["who"]), **GIVEN)
    # A column that nobody uses may have any name.
    unused = arrow.append_column("x", arrow["who"]).append_column("x", arrow["dose"])
    found, plain = (machband.analyze(table, categories=["low", "mid, or so", "high"], **GIVEN) for table in [unused, arrow])
    assert found.files == plain.files and len(found.predict(unused)) == len(arrow)


def test_ids_beyond_floats_stay_apart_beside_missing_ones():
    needs("polars"), needs("pyarrow")
    import polars
    import pyarrow

    ids = pandas.array([None, *(2**53 + place % 12 for place in range(1, 96))], "Int64")
    frame = pandas.DataFrame({"who": ids, "answer": [1, 2, 3, 1] * 24, "dose": ["a", "b"] * 48})
    for table in [frame, polars.from_pandas(frame), pyarrow.Table.from_pandas(frame)]:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            found = machband.analyze(table, subject="who", response="answer", factors="dose", draws=99, on_error="drop")
        assert len(found.tables["subjects"]) == 12


def test_wide_columns_have_their_scale():
    names = ["no", "some", "lots"]
    answers = pandas.Categorical(["lots", "no", "some", "no"], names, ordered=True)
    frame = pandas.DataFrame({"who": [*"abcd"], "x": answers, "y": answers})
    for wide in [["x", "y"], "x,y", "place=x,y"]:
        assert machband.analyze(frame, subject="who", wide=wide, draws=99).model["categories"] == names


@pytest.mark.parametrize("labels", [["no", "some", "lots"], ["no", "few", "some", "lots", "all"]])
def test_a_table_keeps_the_scale_of_its_definition(labels, tmp_path):
    keys = {"schema": 1, "name": "t", "stimulus": {"kind": "mach-band"}, "factors": {"width": [0.05, 0.4]}}
    keys |= {"response": {"labels": labels}, "design": {"repetitions": 6}}
    rows = machband.simulate(keys, participants=3, seed=1, results=tmp_path)
    assert rows.attrs["categories"] == [*range(len(labels))] and machband.read_results(tmp_path).attrs == rows.attrs
    expected = machband.analyze(tmp_path, draws=99)
    assert machband.analyze(rows, draws=99).files == expected.files
    for table in [rows, rows[["subject_id", "width", "rating"]].head(20)]:
        assert f"The scale is from 0 to {len(labels) - 1};" in machband.analyze(table, factors=["width"], draws=99).summary()
    # Without its attributes, the scale is what the ratings show.
    rows.attrs.clear()
    assert machband.analyze(rows, draws=99).llf == pytest.approx(expected.llf)


def test_simulated_stays_simulated(sessions, tmp_path):
    folder, rows = sessions
    said = "These data are simulated: all ratings come from a program"
    groups = pandas.DataFrame({"subject_id": rows.subject_id.unique(), "group": [*"ababab"]})
    merged = rows.merge(groups, on="subject_id")
    assert rows.simulated.all() and merged.simulated.all()
    real = rows.assign(simulated=rows.subject_id == "S001")
    main, some = rows.phase == "main", real.assign(simulated=real.simulated & (rows.trial > 5))
    old = rows.drop(columns="simulated")
    old.attrs["simulated"] = True
    plain = {name: merged[name].to_numpy() for name in ["subject_id", "width", "rating", "simulated"]}
    for table, sentence in [
        (rows, said), (merged, said), (old, said), (plain, said), (rows[["subject_id", "width", "rating"]], said),
        (rows.assign(simulated=1), said), (rows.assign(simulated="True"), said),
        (real, "Some of these data are simulated: 24 of 24 ratings of 1 of 6 participants (S001) come from a program"),
        (some, f"Some of these data are simulated: {(real.simulated & some.simulated & main).sum()} of {(real.simulated & main).sum()} "
               "ratings of 1 of 6 participants (S001) come from a program"),
    ]:
        found = machband.analyze(table, factors=["width"], draws=99)
        for text in [repr(found), found._repr_html_(), found.report]:
            assert sentence in text.replace("\n", " ")
    assert said in machband.analyze(folder, draws=99).report
    assert said in machband.analyze(rows.assign(simulated="yes"), draws=99).report
    assert "simulated:" not in repr(machband.analyze(rows.assign(simulated=False), factors=["width"], draws=99))


def test_a_million_rows_are_as_fast_as_their_csv(tmp_path):
    chosen = np.random.default_rng(1)
    frame = pandas.DataFrame({
        "who": np.array([f"p{i}" for i in range(300)], object)[chosen.integers(0, 300, 1_000_000)],
        "answer": chosen.integers(1, 5, 1_000_000), "dose": chosen.choice(["a", "b"], 1_000_000),
    })
    csv = io.StringIO()
    frame.to_csv(csv, index=False)
    (tmp_path / "big.csv").write_text(csv.getvalue())
    seconds = {"csv": [], "frame": []}
    for _ in range(3):
        for name, data in [("csv", tmp_path / "big.csv"), ("frame", frame)]:
            start = time.process_time()
            machband.analyze(data, slopes="none", **GIVEN)
            seconds[name].append(time.process_time() - start)
    assert min(seconds["frame"]) < 1.1 * min(seconds["csv"])


def test_what_cells_mean_does_not_depend_on_their_type():
    needs("pyarrow")
    import pyarrow

    frame = study(dose=np.float32([0.1, 0.2] * 24))
    categories = frame.astype({"dose": "category"})
    for table in [frame, categories, pyarrow.Table.from_pandas(categories)]:
        assert machband.analyze(table, **GIVEN).tables["cells"]["dose"].tolist() == [0.1, 0.2]
    assert machband.stimulus(size=8, width=np.float32(0.2)).tolist() == machband.stimulus(size=8, width=0.2).tolist()
    with pytest.raises(TypeError, match="expected a list of levels, which has an order"):
        machband.analyze(study(), **{**GIVEN, "factors": {"dose": {"none", "a lot"}}})
    who = pyarrow.DictionaryArray.from_arrays([0, 1, 2, 0] * 12, ["007", None, "8"])
    table = pyarrow.table({"who": who, "answer": [1, 2, 3, 1, 3, 3] * 8, "dose": frame.dose})
    with pytest.raises(machband.Error, match="Table cannot be read: "):
        machband.analyze(table, **GIVEN)


def test_wrong_answers_at_levels_have_their_rows():
    table = {"level": [1.0, 2, 3, 4] * 30, "right": [5, 7, 9, 10] * 30, "n": [10] * 120}
    given = dict(level="level", correct="right", total="n", guess=0.5)
    expected = machband.analyze(table, **given).tables["thresholds"]["threshold"]
    for column, value, message in [
        ("level", "high", 'level is "high"; expected a level, which is a number'),
        ("level", np.inf, 'level is "inf"; expected a level, which is a number'),
        ("right", "x", 'right is "x"; expected a number of correct answers'),
        ("n", 10.5, 'n is "10.5"; expected a number of trials'),
    ]:
        changed = {**table, column: [*table[column][:7], value, *table[column][8:]]}
        changed[column] = np.array(changed[column], object if isinstance(value, str) else None)
        with pytest.raises(machband.DataError, match=f"row 7 .*{message}") as told:
            machband.analyze(changed, **given)
        assert told.value.rows.tolist() == [7]
        with pytest.warns(machband.DataWarning, match=message):
            found = machband.analyze(changed, on_error="drop", **given)
        assert abs(found.tables["thresholds"]["threshold"][0] - expected[0]) < 0.05
    with pytest.raises(machband.Error, match="categories"):
        machband.analyze(table, categories=["a", "b"], **given)


def test_answers_at_levels_keep_the_order_of_their_factors():
    needs("polars")
    import polars

    doses = ["none", "little", "lots", "max"]
    rows = {"x": np.tile([0.1, 0.2, 0.4, 0.8], 32), "right": np.tile([5, 6, 8, 10], 32), "n": [10] * 128}
    rows |= {"who": np.repeat([*"abcd"], 32), "dose": np.tile(np.repeat(doses[::-1], 4), 8), "eye": np.repeat([2, 1] * 2, 32)}
    frame = pandas.DataFrame(rows)
    given = dict(subject="who", level="x", correct="right", total="n", guess=0.5)
    ordered = frame.assign(dose=pandas.Categorical(frame.dose, ["no such", *doses], ordered=True))
    enum = polars.DataFrame(rows).with_columns(dose=polars.col("dose").cast(polars.Enum(doses)))
    for table, factors in [
        (ordered, ["dose"]), (ordered, "dose"), (enum, ["dose"]), (frame, {"dose": doses}), (frame, {"eye": [1, 2], "dose": doses}),
        (ordered, {"dose": doses}),
    ]:
        tables = machband.analyze(table, factors=factors, **given).tables
        for name in ["answers", "thresholds"]:
            assert [*dict.fromkeys(tables[name]["dose"])] == doses, (name, factors)
    with pytest.warns(machband.DataWarning, match="all rows are of one condition, .* if conditions differ in dose, eye"):
        assert machband.analyze(ordered, **given).tables["thresholds"].columns[1] == "trials"
    with pytest.raises(machband.Error, match="most is not a level of dose; expected"):
        machband.analyze(frame, factors={"dose": [*doses, "most"]}, **given)


def test_ordered_columns_that_are_no_factors_have_no_say():
    """The order of a column counts if it is a factor, whatever else is ordered, and only the levels that occur count."""
    needs("polars")
    import polars

    conds = ["some", "few", "none"]
    frame = pandas.DataFrame({"who": [*"abcdefgh"] * 12, "cond": conds * 32, "age": [*"xy"] * 48})
    frame["rating"] = [(7 * i + i // 5) % 4 for i in range(96)]
    given = dict(subject="who", response="rating", factors=["cond"], draws=99)
    expected = machband.analyze(frame, **{**given, "factors": {"cond": conds}})
    assert expected.tables["by_cond"]["cond"].tolist() == conds
    enum = polars.DataFrame(frame).with_columns(cond=polars.col("cond").cast(polars.Enum([*conds, "all"])))
    ordered = frame.assign(
        age=pandas.Categorical(frame.age, ["y", "x"], ordered=True),
        who=pandas.Categorical(frame.who, [*"hgfedcba"], ordered=True),
        cond=pandas.Categorical(frame.cond, ["all", *conds], ordered=True),
    )
    for table in [enum, ordered, ordered.astype({"rating": pandas.CategoricalDtype([0, 1, 2, 3], ordered=True)})]:
        assert machband.analyze(table, **given).tables["by_cond"]["cond"].tolist() == conds
    assert [*machband.analyze(ordered[ordered.cond != "few"], **given).tables["by_cond"]["cond"]] == ["some", "none"]
    assert [*machband.analyze(ordered, **{**given, "factors": None}, terms=["cond"]).tables["by_cond"]["cond"]] == conds
    colon = machband.analyze(ordered.rename(columns={"cond": "near:far"}), **{**given, "factors": None}, terms=['"near:far"'])
    assert {name for name in colon.params.index if "far" in name} == {"near:farfew", "near:farnone"}
    rows = machband.simulate("quick", participants=2, seed=1)
    told = machband.analyze(rows, draws=99).files["by_width.csv"]
    rows["session_id"] = pandas.Categorical(rows.session_id, ordered=True)
    assert machband.analyze(rows, draws=99).files["by_width.csv"] == told
    # A dict that names what is no factor or no level is refused as before.
    with pytest.raises(machband.Error, match="all is not a level of cond"):
        machband.analyze(ordered, **{**given, "factors": {"cond": ["all", *conds]}})


def test_the_default_column_of_participants_is_told_once():
    table = {"level": [1.0, 2, 3, 4] * 30, "right": [5, 7, 9, 10] * 30, "n": [10] * 120, "Participant": [*"ab"] * 60}
    with pytest.warns(machband.DataWarning, match="participants are in the column Participant") as told:
        found = machband.analyze(table, level="level", correct="right", total="n", guess=0.5)
    assert len(told) == 1 and found.summary().startswith("2 participants gave 1,200 answers")


def test_what_is_no_value_is_refused():
    keys = {"schema": 1, "name": "sets", "stimulus": {"kind": "mach-band", "color": "gray"}}
    for wrong in [{"factors": {"color": {"red", "gray"}}}, {"factors": {"color": frozenset(["red"])}}, {"name": b"x"}]:
        with pytest.raises(TypeError, match="cannot be part of a definition; expected a number, text, a list or a dict"):
            machband.Definition.from_dict({**keys, **wrong})
    with pytest.raises(TypeError, match="data is b'x.csv'; expected paths"):
        machband.analyze(b"x.csv")
    for wrong in ["0.5", b"0.5", ["0.5"], 0.5j, [1 + 1j]]:
        with pytest.raises(TypeError, match="expected numbers"):
            machband.interpolate(wrong, 1)
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]])
    for wrong in [corners.astype(complex), corners.astype(str)]:
        with pytest.raises(TypeError, match="(?s)vertices is .*; expected numbers"):
            machband.shade(wrong, [[0, 1, 2]], size=16)
    with pytest.raises(machband.Error, match='rating: "1,0" is not a number; expected numbers'):
        rows = {"subject_id": [*"ab"] * 4, "width": [1, 1, 2, 2] * 2, "rating": ["1,0"] * 6 + ["2", "3"]}
        machband.analyze(rows, factors=["width"])
