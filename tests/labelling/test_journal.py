"""Nothing that was kept is lost, and nothing else gets into a scene."""

import dataclasses
import json
import signal

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from active_perceiver.labelling.journal import Journal, JournalError, journal_path
from active_perceiver.labelling.label_store import ChangedMeanwhileError, Labelling
from active_perceiver.labelling.view_labels import LabelError, ViewLabels, labels_of, with_labels
from active_perceiver.labelling.working_copy import scene_to_label
from active_perceiver.scenes import SceneError, load_scene, save_scene
from active_perceiver.scenes.scene import BOX_TOLERANCE, LABELLED, PROPOSED, UNLABELLED

NAMES = ("ball0", "ball1", "ball2")
NOTHING = ViewLabels(UNLABELLED, {})
DRAWN = ViewLabels(LABELLED, {"ball1": (0.5, 0.5, 0.25, 0.125)})
OTHER = ViewLabels(LABELLED, {"ball0": (0.25, 0.25, 0.5, 0.5), "ball2": (0.75, 0.5, 0.25, 0.25)})


def journal_with(room, *changes):
    journal = Journal(journal_path(room), load_scene(room))
    for view, known in changes:
        journal.append(view, known)
    journal.close()
    return journal.path


def test_changes_come_back_and_the_last_of_a_view_holds(room):
    journal_with(room, (40, DRAWN), (41, OTHER), (40, OTHER), (41, ViewLabels(LABELLED, {})))
    again = Journal(journal_path(room), load_scene(room))
    assert again.changes == {40: OTHER, 41: ViewLabels(LABELLED, {})}
    again.clear()
    again.append(45, DRAWN)
    again.close()
    assert Journal(again.path, load_scene(room)).changes == {45: DRAWN}


def test_a_journal_without_changes_does_not_stay(room):
    assert not journal_with(room).exists()


def test_every_torn_end_leaves_the_lines_before_it(room):
    path = journal_with(room, (40, DRAWN), (41, OTHER))
    whole = path.read_bytes()
    lines = whole.splitlines(keepends=True)
    ends = np.cumsum([len(line) for line in lines])
    for length in sorted({*range(0, len(whole), 11), *(ends - 1), *(ends[:-1]), *(ends[:-1] + 1)}):
        path.write_bytes(whole[:length])
        journal = Journal(path, load_scene(room))
        complete = sum(length >= len(b"".join(lines[: number + 1])) for number in range(3))
        assert list(journal.changes) == [40, 41][: max(0, complete - 1)]
        journal.append(47, DRAWN)  # what comes next is sound again
        journal.close()
        assert 47 in Journal(path, load_scene(room)).changes
        path.unlink()


@pytest.mark.parametrize(
    "line", [b"{]\n", b"7\n", b'{"view":4}\n', b'{"view":99,"label":"labelled","boxes":{}}\n', b"\x00\xff\n", b"\n"]
)
def test_damage_in_the_middle_is_told_and_nothing_is_changed(room, line):
    path = journal_with(room, (40, DRAWN), (41, OTHER))
    lines = path.read_bytes().splitlines(keepends=True)
    path.write_bytes(lines[0] + line + lines[2])
    with pytest.raises(JournalError, match=r"line 2 of .* is damaged"):
        Labelling(room)
    assert path.read_bytes() == lines[0] + line + lines[2]
    np.testing.assert_array_equal(load_scene(room).labels[32:], UNLABELLED)


@pytest.mark.parametrize(
    "header", ['{"format": "other"}', '{"format": "active-perceiver-labels", "version": 2}', '"x"', "[]"]
)
def test_what_is_no_journal_is_refused(room, header):
    path = journal_with(room, (40, DRAWN))
    path.write_text(header + "\n" + path.read_text().splitlines()[1] + "\n")
    with pytest.raises(JournalError, match=r"no journal|damaged"):
        Journal(path, load_scene(room))


def test_the_journal_of_another_scene_is_refused(room, scene):
    path = journal_with(room, (40, DRAWN))
    save_scene(scene, room, force=True)
    with pytest.raises(JournalError, match=r"belongs to another scene .*content_hash differs"):
        Labelling(room)
    assert len(path.read_text().splitlines()) == 2


def test_two_cannot_label_the_same_scene(room):
    labelling = Labelling(room)
    with pytest.raises(JournalError, match="in use"):
        Labelling(room)
    labelling.close()
    Labelling(room).close()


def test_what_cannot_be_written_is_told_and_not_half_kept(room, monkeypatch):
    journal = Journal(journal_path(room), load_scene(room))
    journal.append(40, DRAWN)
    before = journal.path.read_bytes()
    import os

    real = os.write

    def full_disk(file, data):
        real(file, bytes(data)[:5])
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("active_perceiver.labelling.journal.os.write", full_disk)
    with pytest.raises(JournalError, match="No space left"):
        journal.append(41, DRAWN)
    monkeypatch.undo()
    assert journal.path.read_bytes() == before
    assert 41 not in journal.changes
    journal.close()


def test_saving_changes_what_was_changed_and_no_bit_more(room, partly):
    labelling = Labelling(room)
    labelling.change(40, NOTHING, DRAWN)
    known = labelling.views()[20]
    labelling.change(20, known, dataclasses.replace(known, label=LABELLED))
    assert labelling.unsaved == 2
    np.testing.assert_array_equal(load_scene(room).labels, partly.labels)
    assert labelling.save() == 2
    assert labelling.save() == labelling.unsaved == 0
    saved = load_scene(room)
    others = np.delete(np.arange(48), [20, 40])
    np.testing.assert_array_equal(saved.labels[others], partly.labels[others])
    np.testing.assert_array_equal(saved.boxes[others], partly.boxes[others])
    np.testing.assert_array_equal(saved.boxes[20], partly.boxes[20])
    assert saved.labels[[20, 40]].tolist() == [LABELLED, LABELLED]
    assert np.isnan(saved.boxes[40, [0, 2]]).all()
    assert saved.boxes[40, 1].tolist() == [0.5, 0.5, 0.25, 0.125]
    assert saved.views == partly.views
    assert [target.held_out for target in saved.targets] == [2, 2, 2]
    labelling.close()
    assert not journal_path(room).exists()


def test_when_all_is_labelled_the_file_says_so_by_saying_nothing(room):
    labelling = Labelling(room)
    for view, known in enumerate(labelling.views()):
        labelling.change(view, known, dataclasses.replace(known, label=LABELLED))
    labelling.save()
    labelling.close()
    assert load_scene(room).labels is None


def test_a_change_is_made_once_and_only_of_what_is_there(room):
    labelling = Labelling(room)
    labelling.change(40, NOTHING, DRAWN)
    size = journal_path(room).stat().st_size
    labelling.change(40, NOTHING, DRAWN)  # who got no answer asks again
    assert journal_path(room).stat().st_size == size
    with pytest.raises(ChangedMeanwhileError) as refused:
        labelling.change(40, NOTHING, OTHER)
    assert refused.value.current == DRAWN
    with pytest.raises(LabelError, match="no view 48"):
        labelling.change(48, NOTHING, DRAWN)
    with pytest.raises(LabelError, match="no view -1"):
        labelling.change(-1, NOTHING, DRAWN)
    labelling.close()


def test_what_another_program_wrote_meanwhile_stays(room, partly):
    labelling = Labelling(room)
    labelling.change(40, NOTHING, DRAWN)
    save_scene(with_labels(partly, {44: OTHER}), room, force=True)
    labelling.save()
    labelling.close()
    saved = labels_of(load_scene(room))
    assert (saved[40], saved[44]) == (DRAWN, OTHER)


def test_another_scene_in_its_place_is_left_alone(room, scene):
    labelling = Labelling(room)
    labelling.change(40, NOTHING, DRAWN)
    save_scene(scene, room, force=True)
    with pytest.raises(JournalError, match=r"another scene in .* now"):
        labelling.save()
    labelling.close()
    assert load_scene(room).content_hash == scene.content_hash
    assert journal_path(room).exists()


def test_a_save_that_fails_keeps_file_and_journal(room, monkeypatch):
    labelling = Labelling(room)
    labelling.change(40, NOTHING, DRAWN)
    before = room.read_bytes()

    def full_disk(*_, **__):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("active_perceiver.labelling.label_store.save_scene", full_disk)
    with pytest.raises(LabelError, match=r"cannot be written .*keeps the changes"):
        labelling.save()
    monkeypatch.undo()
    assert room.read_bytes() == before
    labelling.close()
    again = Labelling(room)  # the next command saves it
    assert again.recovered == 1
    assert labels_of(load_scene(room))[40] == DRAWN
    again.close()


def test_a_process_that_is_killed_loses_nothing(room, start):
    from test_server import change, post

    server = start(room, "--port", "0")
    assert post(server, "/api/change", change(room, 40, NOTHING, DRAWN))[0] == 200
    server.end(signal.SIGKILL)
    assert labels_of(load_scene(room))[40] == NOTHING
    assert journal_path(room).exists()
    labelling = Labelling(room)
    assert labelling.recovered == 1
    assert labels_of(load_scene(room))[40] == DRAWN
    labelling.close()
    assert not journal_path(room).exists()


def test_asked_to_end_it_saves(room, start):
    from test_server import change, post

    for number, ending in enumerate((signal.SIGINT, signal.SIGTERM, signal.SIGHUP)):
        server = start(room, "--port", "0")
        assert post(server, "/api/change", change(room, 40 + number, NOTHING, DRAWN))[0] == 200
        assert "views changed and saved: 1" in server.end(ending)
        assert server.process.returncode == 0
        assert labels_of(load_scene(room))[40 + number] == DRAWN
        assert not journal_path(room).exists()


coordinates = st.floats(0.01, 0.99)
boxes = st.tuples(coordinates, coordinates, coordinates, coordinates).map(
    lambda c: (c[0], c[1], 2 * c[2] * min(c[0], 1 - c[0]), 2 * c[3] * min(c[1], 1 - c[1]))
)
known_views = st.dictionaries(st.sampled_from(NAMES), boxes).flatmap(
    lambda found: st.builds(
        ViewLabels,
        st.sampled_from((PROPOSED, LABELLED) if found else (UNLABELLED, PROPOSED, LABELLED)),
        st.just(found),
    )
)


@given(st.dictionaries(st.integers(0, 47), known_views))
def test_labels_survive_json_and_the_scene(partly, changes):
    read = {}
    for view, known in changes.items():
        read[view] = ViewLabels.from_json(json.loads(json.dumps(known.as_json())), NAMES)
        assert read[view].label == known.label
        for name, box in known.boxes.items():
            assert read[view].boxes[name] == pytest.approx(box, abs=1e-7)
        assert ViewLabels.from_json(read[view].as_json(), NAMES) == read[view]
    changed = labels_of(with_labels(partly, read))
    assert changed == [read.get(view, known) for view, known in enumerate(labels_of(partly))]


json_values = st.recursive(
    st.none() | st.booleans() | st.floats() | st.integers() | st.text(max_size=5),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.sampled_from(["label", "boxes", *NAMES]), inner),
)


@given(json_values | st.fixed_dictionaries({"label": st.just("labelled"), "boxes": json_values}))
def test_whatever_is_sent_is_sound_or_refused(partly, value):
    try:
        known = ViewLabels.from_json(value, NAMES)
    except LabelError:
        return
    with_labels(partly, {0: known})


@pytest.mark.parametrize(
    "box",
    [
        [0.5, 0.5, 0.0, 0.1], [0.5, 0.5, -0.1, 0.1], [0.9, 0.5, 0.3, 0.1], [150, 150, 30, 30], [0.5, 0.5, 0.1],
        [0.5, 0.5, 1e-60, 0.1], [float("nan")] * 4, [0.5, 0.5, float("inf"), 1], ["0.5"] * 4, [True] * 4, 0.5, None,
        [10**400, 0.5, 0.1, 0.1], [0.5, 0.5, 0.1, 1 + 3 * BOX_TOLERANCE],
    ],
)  # fmt: skip
def test_boxes_that_are_none_are_refused(box):
    with pytest.raises(LabelError, match="the box of 'ball0'"):
        ViewLabels.from_json({"label": "labelled", "boxes": {"ball0": box}}, NAMES)


def test_bundled_scenes_are_only_copied(tmp_path, scene_file):
    with pytest.raises(LabelError, match="label a copy of it, with --out my_conference_room"):
        scene_to_label("conference_room")
    assert scene_to_label(str(scene_file)) == scene_file
    copy = tmp_path / "copy.h5"
    assert scene_to_label(str(scene_file), copy) == copy
    assert load_scene(copy).content_hash == load_scene(scene_file).content_hash
    with pytest.raises(FileExistsError):
        scene_to_label(str(scene_file), copy)
    scene_to_label(str(scene_file), copy, force=True)
    journal_path(copy).write_text("{}\n")
    with pytest.raises(FileExistsError, match="keeps changes"):
        scene_to_label(str(scene_file), copy, force=True)


def test_a_scene_without_targets_cannot_be_labelled(room, partly):
    bare = dataclasses.replace(partly, targets=(), boxes=partly.boxes[:, :0])
    save_scene(bare, room, force=True)
    with pytest.raises(SceneError, match="no objects"):
        Labelling(room)
    assert not journal_path(room).exists()
