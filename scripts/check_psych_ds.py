#!/usr/bin/env python3
"""Checks folders against the rules of Psych-DS 1.5 and reports the codes of its validator.

    check_psych_ds.py FOLDER...      # prints errors and warnings; the exit status is 1 if there are errors
    check_psych_ds.py --self-test FOLDER
                                     # breaks copies of a valid data set in every known way and checks that each is
                                     # detected

The official validator runs on Deno and is not available from an ordinary package registry. This script implements its
published rules (https://psychds-docs.readthedocs.io) with the standard library only. It knows only the properties of
schema.org that machband's data sets use.
"""

import csv
import fnmatch
import io
import json
import pathlib
import re
import shutil
import sys
import tempfile

NAME = re.compile(r"([a-z]+-[a-zA-Z0-9]+)(_[a-z]+-[a-zA-Z0-9]+)*_data\.csv")
OFFICIAL = {"study", "site", "subject", "session", "task", "condition", "trial", "stimulus", "description"}
REQUIRED = ["name", "description", "variableMeasured"]
# The properties of a schema.org Dataset that are used here, including the properties of a PropertyValue for a column.
DATASET = set(REQUIRED) | {
    "author", "citation", "creator", "dateCreated", "dateModified", "datePublished", "funder", "identifier", "keywords",
    "license", "privacyPolicy", "schemaVersion", "temporalCoverage", "url", "version",
}
IGNORED = [
    ".git*", "*.DS_Store", ".datalad/", ".reproman/", "sourcedata/", "code/", "stimuli/", "materials/", "results/",
    "products/", "analysis/", "documentation/", "log/",
]
FOLDERS = ["analysis", "results", "materials", "documentation"]
SCHEMA_ORG = re.compile(r"https?://schema\.org/?")


class Dataset:
    """A folder and its faults."""

    def __init__(self, root):
        self.root = pathlib.Path(root)
        self.found = []
        self.description = None

    def say(self, level, code, path, text=""):
        self.found.append((level, code, str(path), text))

    def error(self, code, path, text=""):
        self.say("error", code, path, text)

    def warning(self, code, path, text=""):
        self.say("warning", code, path, text)

    def check(self):
        ignored = self.ignored()
        files = [path for path in sorted(self.root.rglob("*")) if path.is_file()]
        files = [path for path in files if not ignored(path.relative_to(self.root).as_posix())]
        description = self.root / "dataset_description.json"
        if not description.is_file():
            self.error("MISSING_DATASET_DESCRIPTION", description)
        else:
            self.description = self.json(description)
        if not (self.root / "data").is_dir():
            self.error("MISSING_DATA_DIRECTORY", self.root / "data")
        data = [path for path in files if self.below_data(path) and path.name.endswith("_data.csv")]
        if not data:
            self.error("MISSING_DATAFILE", self.root / "data")
        for path in files:
            self.place(path)
        for path in data:
            self.data_file(path)
        self.recommended()
        return self.found

    def below_data(self, path):
        return path.relative_to(self.root).parts[0] == "data"

    def ignored(self):
        patterns = list(IGNORED)
        for name in [".psychdsignore"]:
            if (self.root / name).is_file():
                lines = (self.root / name).read_text(encoding="utf-8").splitlines()
                patterns += [line.strip() for line in lines if line.strip() and not line.startswith("#")]

        def test(path):
            parts = path.split("/")
            for pattern in patterns:
                if pattern.endswith("/"):
                    if any(fnmatch.fnmatch(part, pattern[:-1]) for part in parts[:-1]):
                        return True
                elif any(fnmatch.fnmatch(part, pattern) for part in parts):
                    return True
            return False

        return test

    def json(self, path):
        try:
            value = json.loads(path.read_bytes().decode("utf-8"))
        except ValueError as error:
            self.error("INVALID_JSON_FORMATTING", path, str(error))
            return None
        if not isinstance(value, dict):
            self.error("INVALID_JSON_FORMATTING", path, "not an object")
            return None
        return value

    def place(self, path):
        """Whether any rule covers a file, and whether its location is allowed."""
        inside = path.relative_to(self.root).as_posix()
        if path.stat().st_size == 0:
            self.warning("FILE_EMPTY", path)
        if path.name == "dataset_description.json" and inside != path.name:
            self.warning("WRONG_METADATA_LOCATION", path)
        own = "/" not in inside and (
            path.name in {"dataset_description.json", ".psychdsignore"} or path.stem in {"README", "CHANGES"}
        )
        tables = self.below_data(path) and (path.name.endswith(("_data.csv", "_data.json")) or path.name == "file_metadata.json")
        if not own and not tables:
            self.warning("FILE_NOT_CHECKED", path)

    def data_file(self, path):
        if not NAME.fullmatch(path.name):
            self.error("FILENAME_KEYWORD_FORMATTING_ERROR", path)
        else:
            unofficial = {part.split("-")[0] for part in path.name[: -len("_data.csv")].split("_")} - OFFICIAL
            if unofficial:
                self.warning("FILENAME_UNOFFICIAL_KEYWORD_WARNING", path, ", ".join(sorted(unofficial)))
        header = self.table(path)
        if self.description is not None:
            self.metadata(path, header)

    def table(self, path):
        try:
            text = path.read_bytes().decode("utf-8-sig")
            rows = list(csv.reader(io.StringIO(text, newline=""), strict=True))
        except (UnicodeDecodeError, csv.Error) as error:
            self.error("CSV_FORMATTING_ERROR", path, str(error))
            return []
        if not rows or not rows[0]:
            self.error("CSV_HEADER_MISSING", path)
            return []
        header = rows[0]
        for number, row in enumerate(rows[1:], 2):
            if len(row) != len(header):
                self.error("CSV_HEADER_LENGTH_MISMATCH", path, f"row {number} has {len(row)} cells, not {len(header)}")
        if "row_id" in header:
            place = header.index("row_id")
            ids = [row[place] for row in rows[1:] if len(row) > place]
            if len(set(ids)) != len(ids):
                self.error("ROWID_VALUES_NOT_UNIQUE", path)
        return header

    def metadata(self, path, header):
        """The metadata of a data file: the description, each file_metadata.json on its path, and its sidecar. Later values
        replace earlier ones, key by key."""
        parts = [self.description]
        folder = self.root
        for name in path.relative_to(self.root).parts[:-1]:
            folder = folder / name
            if (folder / "file_metadata.json").is_file():
                parts.append(self.json(folder / "file_metadata.json") or {})
        sidecar = path.with_suffix(".json")
        if sidecar.is_file():
            parts.append(self.json(sidecar) or {})
        merged, own = {}, {}
        for part in parts:
            own.update(null_keys(part.get("@context")))
            merged.update({key: value for key, value in part.items() if key != "@context"})
        context = self.description.get("@context")
        vocabulary = context.get("@vocab") if isinstance(context, dict) else context
        known = isinstance(vocabulary, str) and SCHEMA_ORG.fullmatch(vocabulary)
        kind = merged.get("@type", merged.get("type"))
        if kind is None:
            self.error("MISSING_DATASET_TYPE", path)
        elif kind not in {"Dataset", "schema:Dataset", "http://schema.org/Dataset", "https://schema.org/Dataset"} or not known:
            self.error("INCORRECT_DATASET_TYPE", path, str(kind))
        missing = [key for key in REQUIRED if key not in merged or not known or key in own]
        if missing:
            self.error("JSON_KEY_REQUIRED", path, ", ".join(missing))
        variables = merged.get("variableMeasured", [])
        variables = variables if isinstance(variables, list) else [variables]
        named = {one if isinstance(one, str) else one.get("name") for one in variables}
        absent = [name for name in header if name not in named]
        if absent:
            self.error("CSV_COLUMN_MISSING_FROM_METADATA", path, ", ".join(absent))
        if any(isinstance(one, dict) and "@type" not in one for one in variables):
            self.warning("OBJECT_TYPE_MISSING", path, "variableMeasured")
        strange = [key for key in merged if not key.startswith("@") and key not in DATASET and key not in own]
        if strange:
            self.warning("INVALID_SCHEMAORG_PROPERTY", path, ", ".join(strange))

    def recommended(self):
        for stem in ["README", "CHANGES"]:
            if not any(self.root.glob(stem + "*")):
                self.warning(f"MISSING_{stem}_DOC", self.root)
        if not (self.root / ".psychdsignore").is_file():
            self.warning("MISSING_PSYCHDSIGNORE", self.root)
        for folder in FOLDERS:
            if not (self.root / folder).is_dir():
                self.warning(f"MISSING_{folder.upper()}_DIRECTORY", self.root)


def null_keys(context):
    """The keys that the context maps to null, so that they have no meaning in schema.org."""
    return {key: None for key, value in context.items() if value is None} if isinstance(context, dict) else {}


def report(root):
    found = Dataset(root).check()
    for level, code, path, text in found:
        print(f"{level}: {code}: {path}" + (f": {text}" if text else ""))
    errors = sum(level == "error" for level, *_ in found)
    print(f"{root}: {errors} errors, {len(found) - errors} warnings")
    return errors


def breakages(folder):
    """Ways to break a copy, each with the code that must be reported."""
    table = sorted((folder / "data").glob("*_data.csv"))[0]
    sidecar = table.with_suffix(".json")
    description = folder / "dataset_description.json"

    def edit(path, change):
        value = json.loads(path.read_text(encoding="utf-8"))
        change(value)
        path.write_text(json.dumps(value), encoding="utf-8")

    def append(text):
        with table.open("a", encoding="utf-8") as file:
            file.write(text)

    lines = table.read_text(encoding="utf-8").splitlines(keepends=True)
    wide = len(lines[0].split(","))
    return [
        ("MISSING_DATASET_DESCRIPTION", description.unlink),
        ("MISSING_DATA_DIRECTORY", lambda: shutil.move(folder / "data", folder / "daten")),
        ("MISSING_DATAFILE", lambda: [path.unlink() for path in (folder / "data").glob("*_data.csv")]),
        ("INVALID_JSON_FORMATTING", lambda: description.write_text("{", encoding="utf-8")),
        ("INVALID_JSON_FORMATTING", lambda: sidecar.write_bytes(b'{"a": "\xff"}')),
        ("MISSING_DATASET_TYPE", lambda: edit(description, lambda value: value.pop("@type"))),
        ("INCORRECT_DATASET_TYPE", lambda: edit(description, lambda value: value.update({"@type": "Thing"}))),
        ("INCORRECT_DATASET_TYPE", lambda: edit(description, lambda value: value.pop("@context"))),
        ("JSON_KEY_REQUIRED", lambda: edit(description, lambda value: value.pop("description"))),
        ("CSV_COLUMN_MISSING_FROM_METADATA", lambda: edit(description, lambda value: value["variableMeasured"].pop())),
        ("CSV_COLUMN_MISSING_FROM_METADATA", lambda: edit(sidecar, lambda value: value.update(variableMeasured=["row_id"]))),
        ("CSV_HEADER_MISSING", lambda: table.write_text("", encoding="utf-8")),
        ("CSV_HEADER_LENGTH_MISMATCH", lambda: append("S001_1_main_00")),
        ("CSV_FORMATTING_ERROR", lambda: append('"a"b' + "," * (wide - 1) + "\n")),
        ("CSV_FORMATTING_ERROR", lambda: table.write_bytes(table.read_bytes() + b"\xff" + b"," * (wide - 1))),
        ("ROWID_VALUES_NOT_UNIQUE", lambda: append(lines[-1])),
        ("FILENAME_KEYWORD_FORMATTING_ERROR", lambda: table.rename(table.with_name("Subject_1_data.csv"))),
        ("FILENAME_UNOFFICIAL_KEYWORD_WARNING", lambda: table.rename(table.with_name("person-1_data.csv"))),
        ("FILE_NOT_CHECKED", lambda: (folder / "notes.txt").write_text("x", encoding="utf-8")),
        ("INVALID_SCHEMAORG_PROPERTY", lambda: edit(sidecar, lambda value: value.pop("@context"))),
        ("OBJECT_TYPE_MISSING", lambda: edit(description, lambda value: value["variableMeasured"][0].pop("@type"))),
        ("FILE_EMPTY", lambda: (folder / "README.md").write_text("", encoding="utf-8")),
        ("WRONG_METADATA_LOCATION", lambda: shutil.copy(description, folder / "data")),
        ("MISSING_README_DOC", (folder / "README.md").unlink),
        ("MISSING_PSYCHDSIGNORE", (folder / ".psychdsignore").unlink),
    ]


def codes(root):
    """The distinct codes reported for a data set."""
    return {(code, pathlib.Path(path).relative_to(root).as_posix()) for _, code, path, _ in Dataset(root).check()}


def self_test(root):
    before = codes(root)
    unseen = 0
    with tempfile.TemporaryDirectory() as scratch:
        count = 0
        while True:
            copy = pathlib.Path(scratch) / str(count)
            shutil.copytree(root, copy)
            ways = breakages(copy)
            if count == len(ways):
                break
            code, breaking = ways[count]
            breaking()
            if code not in {found for found, _ in codes(copy) - before}:
                print(f"error: {code} was not reported for a data set that has this fault")
                unseen += 1
            count += 1
    print(f"self-test: {count - unseen} of {count} faults found")
    return unseen


def main(arguments):
    if not arguments:
        print(__doc__, file=sys.stderr)
        return 2
    if arguments[0] == "--self-test":
        return 1 if self_test(pathlib.Path(arguments[1])) else 0
    return 1 if sum(report(root) for root in arguments) else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
