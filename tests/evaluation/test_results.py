"""Results are kept from the moment they are added, and read as Parquet."""

import json
import os
from dataclasses import dataclass

import pytest

from bt_manip.evaluation import EpisodeResult, ResultFolder, read_results, results
from bt_manip.exceptions import BtManipError

pytest.importorskip("pyarrow")
from pyarrow import parquet

POINTS = ({"speed": 0.5, "robot": "panda"}, {"speed": 1.0, "robot": "ur5e"})
IDENTITY = {"tree": "t", "seed": 0, "points": [dict(point) for point in POINTS]}


def result(episode, point=0):
    return EpisodeResult(point, episode, 0, True, "SUCCESS", digest=f"{point}-{episode}")


@dataclass(frozen=True)
class Measured(EpisodeResult):
    distance: float | None = None


@pytest.fixture
def folder(tmp_path):
    return lambda **more: ResultFolder(tmp_path / "out", {**IDENTITY, **more}, POINTS)


def test_rows_have_the_varied_parameters_and_the_identity(folder, tmp_path):
    with folder() as writing:
        writing.add(result(0))
        writing.add(result(0, point=1))
    table = parquet.read_table(tmp_path / "out")
    assert table["vary.speed"].to_pylist() == [0.5, 1.0]
    assert table["vary.robot"].to_pylist() == ["panda", "ur5e"]
    assert table["digest"].to_pylist() == ["0-0", "1-0"]
    assert json.loads(table.schema.metadata[b"bt_manip"]) == IDENTITY


def test_a_new_column_may_be_empty_and_is_in_results_of_before(folder, tmp_path, monkeypatch):
    with folder() as writing:
        writing.add(result(0))
    monkeypatch.setattr(results, "EpisodeResult", Measured)
    rows = [Measured(0, i, 0, True, "SUCCESS", distance=d) for i, d in ((1, 0.25), (2, None))]
    with folder() as again:
        assert [one.distance for one in again.results] == [None]
        for row in rows:
            again.add(row)
    assert [one.distance for one in read_results(tmp_path / "out")[1]] == [None, 0.25, None]


def test_every_added_result_survives_a_killed_process(folder, tmp_path, monkeypatch):
    monkeypatch.setattr(results, "PART_ROWS", 4)
    killed = folder()
    for episode in range(10):
        killed.add(result(episode))
    assert len(list((tmp_path / "out").glob("part-*"))) == 2
    os.close(killed._journal)  # as the end of a process does
    with (tmp_path / "out" / results.JOURNAL).open("a") as journal:
        journal.write('{"episode": 10, "poi')
    with folder() as again:
        assert [one.episode for one in again.results] == list(range(10))
        again.add(result(10))
    assert parquet.read_table(tmp_path / "out")["episode"].to_pylist() == list(range(11))
    assert [one.episode for one in read_results(tmp_path / "out")[1]] == list(range(11))


def test_a_process_killed_between_part_and_journal_leaves_no_row_twice(folder, tmp_path):
    with folder() as writing:
        writing.add(result(0))
    (tmp_path / "out" / results.JOURNAL).write_text(json.dumps(vars(result(0))) + "\n")
    with folder() as again:
        assert [one.episode for one in again.results] == [0]
    assert parquet.read_table(tmp_path / "out").num_rows == 1


def test_a_file_of_another_evaluation_in_the_folder_is_refused(folder, tmp_path):
    folder().close()
    with ResultFolder(tmp_path / "other", {**IDENTITY, "seed": 3}, POINTS) as other:
        other.add(result(0))
    part = tmp_path / "out" / "part-00000.parquet"
    part.write_bytes((tmp_path / "other" / part.name).read_bytes())
    for read in (folder, lambda: read_results(tmp_path / "out")):
        with pytest.raises(BtManipError, match="part-00000.parquet' is of another eval.* seed 3"):
            read()
    part.unlink()
    folder().close()  # the one that was refused does not write it


def test_a_folder_has_one_writer_and_its_results(folder, tmp_path):
    with folder(), pytest.raises(BtManipError, match="is being written by another evaluation"):
        folder()
    with pytest.raises(BtManipError, match="cannot be read"):
        read_results(tmp_path)
