"""Studies from text and files, and the paper's scenes that come with the package."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from tests.studies.documents import faults_of, fields_of

from damperlab.studies.faults import Fault, StudyFaults
from damperlab.studies.guard import MAX_VALUES
from damperlab.studies.reading import named_descriptions, named_studies, parse_study_text, read_study
from damperlab.studies.specification.reading import read_specification
from damperlab.studies.text import MAX_BYTES, MAX_YAML_VALUES, Format

JSON = '{"axes": {"clearance_ratio": [5, 10], "frequency_ratio": 1e0}}'
YAML = """
# a comment
axes:
  clearance_ratio: [5, 10]
  frequency_ratio: {start: .5, stop: 1.5e+0, num: 3}
steady: {tolerance: 1e-4}
particle: true
name: 2024-01-01
"""


def only_fault(text: str | bytes, written_in: Format) -> Fault:
    (fault,) = faults_of(parse_study_text, text, written_in)
    return fault


def test_json_and_yaml_give_the_same_study() -> None:
    from_yaml = parse_study_text("axes: {clearance_ratio: [5, 10], frequency_ratio: 1}", "yaml")
    assert parse_study_text(JSON, "json") == from_yaml == parse_study_text(JSON, "yaml")
    assert parse_study_text(b"\xef\xbb\xbf" + JSON.encode(), "json") == from_yaml


def test_yaml_numbers_need_no_dot_and_texts_are_not_guessed() -> None:
    study = parse_study_text(YAML, "yaml")
    assert study.steady.tolerance == 1e-4
    assert study.name == "2024-01-01"
    assert study.coordinates["frequency_ratio"].tolist() == [0.5, 1.0, 1.5]
    assert only_fault(YAML.replace("particle: true", "particle: yes"), "yaml").field == "particle"
    assert only_fault(YAML.replace(".5,", "'.5',"), "yaml").field == "axes.frequency_ratio.start"


@pytest.mark.parametrize(
    ("text", "written_in", "place"),
    [
        ('{"axes":\n  }', "json", "line 2, column 3"),
        ("", "json", "line 1, column 1"),
        ("axes: {a: [1, 2}", "yaml", "line 1, column 16"),
        ("a: 1\n b: 2", "yaml", "line 2, column 3"),
        ("a: &x [1]\nb: *x", "yaml", "line 2, column 4"),
        ("a: !!python/name:os.system 1", "yaml", "line 1, column 4"),
        ("a: 1\n---\nb: 2", "yaml", "line 2, column 1"),
        ("{a: 1}: 2", "yaml", "line 1, column 1"),
    ],
)
def test_syntax_faults_have_a_line_and_a_column(text: str, written_in: Format, place: str) -> None:
    assert place in only_fault(text, written_in).found


@pytest.mark.parametrize("written_in", ["json", "yaml"])
def test_repeated_keys_are_refused_beside_other_faults(written_in: Format) -> None:
    text = '{"axes": {"clearance_ratio": 5, "clearance_ratio": 6, "frequency_ratio": -1}, "axes_": 1, "axes_": 2}'
    fields = fields_of(parse_study_text, text, written_in)
    assert sorted(fields) == ["axes.clearance_ratio", "axes.frequency_ratio", "axes_", "axes_"]


@pytest.mark.parametrize(
    ("spelled", "written_in"),
    [
        *((each, "json") for each in ("NaN", "Infinity", "-Infinity", "1e999", "9" * 10_000)),
        *((each, "yaml") for each in (".nan", ".inf", "-.inf", "1e999", "9" * 10_000)),
    ],
)
def test_numbers_that_are_not_finite_are_named_where_they_stand(spelled: str, written_in: Format) -> None:
    text = JSON.replace("[5, 10]", f"[5, {spelled}]")
    assert only_fault(text, written_in).field == "axes.clearance_ratio[1]"


@pytest.mark.parametrize("opening", ["[", '{"a":', "- ", "? ", "[{", "{a: "])
@pytest.mark.parametrize("written_in", ["json", "yaml"])
def test_deep_nesting_is_refused(opening: str, written_in: Format) -> None:
    only_fault(opening * (30_000 // len(opening)), written_in)
    only_fault(opening * 400, written_in)


def test_size_is_refused_before_anything_is_read() -> None:
    for written_in, limit in MAX_BYTES.items():
        assert f"{limit:,}" in only_fault(" " * (limit + 1), written_in).allowed
    assert "UTF-8" in only_fault(b"\xff\xfe", "json").allowed
    values = ",".join(["1"] * (2 * MAX_VALUES + 2))
    assert f"{MAX_VALUES:,}" in only_fault(f'{{"axes": [{values}]}}', "json").allowed


def test_values_in_yaml_are_counted_while_they_are_read() -> None:
    assert f"{MAX_YAML_VALUES:,}" in only_fault("[" + "1," * MAX_YAML_VALUES + "]", "yaml").allowed


PUNCTUATION = st.text(alphabet='[]{}:,-?&*!|>"\n #ab1.e', max_size=40)


@given(st.binary(max_size=60) | st.text(max_size=60) | PUNCTUATION, st.sampled_from(["json", "yaml"]))
@example("a: \0", "yaml")
@example("a: \ud800", "yaml")
@example('{"\\ud800": "\\ud800"}', "json")
@example("%YAML 9.9\n---\na: 1", "yaml")
@example("<<: {a: 1}", "yaml")
@settings(max_examples=80, deadline=None)
def test_arbitrary_text_only_ever_raises_study_faults(text: str | bytes, written_in: Format) -> None:
    with pytest.raises(StudyFaults) as caught:
        parse_study_text(text, written_in)
    str(caught.value).encode("utf-8")


def test_a_file_of_the_other_kind_or_of_none_is_told_so_in_one_line(tmp_path: Path) -> None:
    (tmp_path / "study.json").write_text(JSON)
    (tmp_path / "specification.yaml").write_text("structure: {mass_kg: 1}\nchoose: {}\n")
    (tmp_path / "empty.yaml").write_text(" \n")
    (tmp_path / "map.png").write_bytes(b"\x89PNG\r\n\x1a\n\0\0\0\r")
    (tmp_path / "map.yaml").write_bytes(b"\x89PNG\r\n\x1a\n\0\0\0\r")
    for read, name, told in (
        (
            read_study,
            str(tmp_path / "specification.yaml"),
            "a specification, not a study.*`damperlab design`",
        ),
        (read_specification, str(tmp_path / "study.json"), "a study, not a specification.*`damperlab run`"),
        (read_study, "prototype", "named specification, not a study.*`damperlab design prototype`"),
        (read_specification, "figure-11", "named study, not a specification.*`damperlab run figure-11`"),
        (read_study, str(tmp_path / "empty.yaml"), "is empty"),
        (read_study, str(tmp_path / "map.png"), "is no study"),
        (read_specification, str(tmp_path / "map.yaml"), "is binary, not text"),
    ):
        with pytest.raises(StudyFaults, match=told) as caught:
            read(name)
        assert len(caught.value.faults) == 1


def test_files_are_read_by_their_suffix(tmp_path: Path) -> None:
    (tmp_path / "a.json").write_text(JSON)
    (tmp_path / "a.yml").write_text(JSON)
    assert read_study(str(tmp_path / "a.json")) == read_study(str(tmp_path / "a.yml"))
    (tmp_path / "large.yaml").write_bytes(b" " * 200_000)
    (tmp_path / "folder.json").mkdir()
    for name in ("large.yaml", "folder.json", "none.yaml", "none.txt", "a\0.json", "x" * 5000 + ".json"):
        with pytest.raises(StudyFaults):
            read_study(str(tmp_path / name))
    with pytest.raises(
        StudyFaults, match=r'"frame" is neither a file nor a named study.*`damperlab studies`'
    ):
        read_study("frame")
    with pytest.raises(StudyFaults, match="figure-11"):
        read_study("figure-12")


def test_named_studies_carry_their_names_and_parse_back() -> None:
    studies = named_studies()
    paper = {"figure-7", "figure-8", "figure-9", "figure-11", "figure-14", "table-3"}
    beyond = {"design-map", "figure-11-band", "hysteresis-up", "hysteresis-down", "attractors"}
    assert set(studies) == paper | beyond
    for name, study in studies.items():
        assert study.name == name
        assert read_study(name) == study
        assert study.coordinates["damping_ratio"].tolist() == [0.0038]
    assert len({study.digest for study in studies.values()}) == len(studies)
    words = named_descriptions()
    assert set(words) == set(studies)
    # whoever reads of one way of the hysteresis is told of the other, and of the command that shows both
    assert "response hysteresis-up --with hysteresis-down" in words["hysteresis-up"]


def test_figure_11_is_the_papers_plane_at_resonance() -> None:
    at = read_study("figure-11").coordinates
    assert np.array_equal(at["clearance_ratio"], np.arange(2, 51) / 2)
    np.testing.assert_allclose(at["friction_ratio"], np.arange(33) / 40, rtol=4e-16)
    fixed = {name: float(v[0]) for name, v in at.items() if len(v) == 1}
    assert fixed == {"damping_ratio": 0.0038, "restitution": 0.47, "mass_ratio": 0.1, "frequency_ratio": 1.0}
